// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;

namespace OpenRoIS
{
    /// <summary>What a message of a component carries: values by name. Those that are not asked for are passed over.</summary>
    public sealed class Payload
    {
        private readonly Dictionary<string, Result> _values = new Dictionary<string, Result>();

        private Payload(IEnumerable<Result> values)
        {
            foreach (Result value in values)
            {
                _values[value.Name] = value;
            }
        }

        /// <summary>Reads values as they came.</summary>
        /// <exception cref="ComponentFailedException">one is missing, or does not fit its type</exception>
        internal static T Read<T>(string what, IEnumerable<Result> values, Func<Payload, T> read)
        {
            try
            {
                return read(new Payload(values));
            }
            catch (FormatException error)
            {
                throw new ComponentFailedException(what + " returned a value that does not fit: " + error.Message);
            }
        }

        /// <summary>Returns a value; null where there is none.</summary>
        /// <param name="name">its name</param>
        /// <param name="dataTypeRef">its type, as in the catalog</param>
        /// <exception cref="FormatException">it does not fit its type</exception>
        public object Find(string name, string dataTypeRef)
        {
            Result value;
            return _values.TryGetValue(name, out value) ? Named(name, () => Values.Decode(dataTypeRef, value.Value)) : null;
        }

        /// <summary>Returns a value.</summary>
        /// <exception cref="FormatException">it is not there, or does not fit its type</exception>
        public T Value<T>(string name, string dataTypeRef)
        {
            object found = Find(name, dataTypeRef);
            if (found == null)
            {
                throw new FormatException(name + " is missing");
            }
            return As<T>(name, found);
        }

        /// <summary>Returns a list.</summary>
        /// <exception cref="FormatException">it is not there, or does not fit its type</exception>
        public IReadOnlyList<T> List<T>(string name, string dataTypeRef)
        {
            return Value<object[]>(name, dataTypeRef).Select(each => As<T>(name, each)).ToArray();
        }

        /// <summary>Returns a list; null where there is none.</summary>
        /// <exception cref="FormatException">it does not fit its type</exception>
        public IReadOnlyList<T> FindList<T>(string name, string dataTypeRef)
        {
            return _values.ContainsKey(name) ? List<T>(name, dataTypeRef) : null;
        }

        /// <summary>Returns a moment.</summary>
        /// <exception cref="FormatException">it is not there, or is none</exception>
        public DateTimeOffset Moment(string name)
        {
            return Named(name, () => Values.DecodeMoment(Value<string>(name, "DateTime")));
        }

        /// <summary>Returns a moment; null where there is none.</summary>
        /// <exception cref="FormatException">it is none</exception>
        public DateTimeOffset? FindMoment(string name)
        {
            return _values.ContainsKey(name) ? Moment(name) : (DateTimeOffset?)null;
        }

        /// <summary>Returns an enumerator.</summary>
        /// <exception cref="FormatException">it is not there, or is none</exception>
        public T Enumerator<T>(string name)
            where T : struct
        {
            T? found = FindEnumerator<T>(name);
            if (found == null)
            {
                throw new FormatException(name + " is missing");
            }
            return found.Value;
        }

        /// <summary>Returns an enumerator; null where there is none.</summary>
        /// <exception cref="FormatException">it is none</exception>
        public T? FindEnumerator<T>(string name)
            where T : struct
        {
            var text = (string)Find(name, "string");
            if (text == null)
            {
                return null;
            }
            foreach (object member in Enum.GetValues(typeof(T)))
            {
                if (RoISJson.NameOf(member) == text)
                {
                    return (T)member;
                }
            }
            throw new FormatException(name + ": " + text + " is no " + typeof(T).Name);
        }

        private static T As<T>(string name, object found)
        {
            if (!(found is T))
            {
                throw new FormatException(
                    name + " is read as " + found.GetType().Name + ", not as " + typeof(T).Name);
            }
            return (T)found;
        }

        private static T Named<T>(string name, Func<T> read)
        {
            try
            {
                return read();
            }
            catch (FormatException error)
            {
                throw new FormatException(name + ": " + error.Message);
            }
        }
    }
}
