// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Text.RegularExpressions;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;

namespace OpenRoIS
{
    /// <summary>
    /// Values as texts of the wire, read and written as their <c>data_type_ref</c> says: an integer is a <c>long</c>, a
    /// number a <c>double</c>, a truth value a <c>bool</c>, a list an array of these; all else is text.
    /// </summary>
    public static class Values
    {
        private const int Deepest = 8;

        private static readonly Regex Integer = new Regex("^-?[0-9]{1,20}\\z");
        private static readonly Regex Number = new Regex("^-?[0-9]{1,40}(\\.[0-9]{1,40})?([eE][+-]?[0-9]{1,4})?\\z");
        private static readonly Regex Moment = new Regex(
            "^[0-9]{4}-[0-9]{2}-[0-9]{2}[T ][0-9]{2}:[0-9]{2}(:[0-9]{2}([.,][0-9]+)?)?(Z|[+-][0-9]{2}(:?[0-9]{2})?)?\\z");

        private enum Kind
        {
            Text,
            Integer,
            Number,
            Truth,
            ComponentStatus,
            StreamStatus
        }

        /// <summary>Reads the text of a value.</summary>
        /// <exception cref="FormatException">it does not fit its type, or is an integer of more than 64 bits</exception>
        public static object Decode(string dataTypeRef, string text)
        {
            string code = dataTypeRef.ToLowerInvariant();
            if (!code.EndsWith("[]"))
            {
                return DecodeScalar(KindOf(code), dataTypeRef, text);
            }
            JToken read;
            try
            {
                read = StrictJson.Parse(text);
            }
            catch (JsonException)
            {
                throw new FormatException(Shown(text) + " is not a JSON array");
            }
            return DecodeList(code, read, 0);
        }

        /// <summary>Writes a value as the text of its type; a moment becomes ISO 8601, an enumerator its name.</summary>
        /// <exception cref="FormatException">it does not fit its type: it is of another one, no finite number, or no
        /// enumerator</exception>
        public static string Encode(string dataTypeRef, object value)
        {
            string code = dataTypeRef.ToLowerInvariant();
            JToken plain = Plain(value, 0);
            if (code.EndsWith("[]"))
            {
                DecodeList(code, plain, 0);
                return plain.ToString(Formatting.None);
            }
            Kind kind = KindOf(code);
            if (!Fits(kind, plain))
            {
                throw new FormatException(Shown(plain.ToString()) + " is not of type " + dataTypeRef);
            }
            return plain.Type == JTokenType.String ? (string)plain : plain.ToString(Formatting.None);
        }

        /// <summary>Reads a DateTime; one without an offset is taken for UTC.</summary>
        /// <exception cref="FormatException">it is not a date and a time of ISO 8601</exception>
        public static DateTimeOffset DecodeMoment(string text)
        {
            DateTimeOffset moment;
            // A fraction may have more digits than a tick.
            string known = Regex.Replace(text, @"[.,]([0-9]{1,7})[0-9]*", ".$1");
            if (Moment.IsMatch(text) && DateTimeOffset.TryParse(
                known, CultureInfo.InvariantCulture, DateTimeStyles.AssumeUniversal, out moment))
            {
                return moment;
            }
            throw new FormatException(
                Shown(text) + " is no date and time of ISO 8601, such as 2026-06-01T12:00:00+00:00");
        }

        private static Kind KindOf(string code)
        {
            switch (code)
            {
                case "int":
                case "integer":
                case "long":
                case "short":
                    return Kind.Integer;
                case "float":
                case "double":
                    return Kind.Number;
                case "bool":
                case "boolean":
                    return Kind.Truth;
                case "component_status":
                    return Kind.ComponentStatus;
                case "stream_status":
                    return Kind.StreamStatus;
                default:
                    return Kind.Text;
            }
        }

        private static object DecodeScalar(Kind kind, string dataTypeRef, string text)
        {
            long whole;
            double number;
            switch (kind)
            {
                case Kind.Integer:
                    if (Integer.IsMatch(text)
                        && long.TryParse(text, NumberStyles.AllowLeadingSign, CultureInfo.InvariantCulture, out whole))
                    {
                        return whole;
                    }
                    break;
                case Kind.Number:
                    if (Number.IsMatch(text)
                        && double.TryParse(text, NumberStyles.Float, CultureInfo.InvariantCulture, out number)
                        && !double.IsInfinity(number))
                    {
                        return number;
                    }
                    break;
                case Kind.Truth:
                    if (text == "true" || text == "false")
                    {
                        return text == "true";
                    }
                    break;
                case Kind.ComponentStatus:
                    if (IsNameOf<ComponentStatus>(text))
                    {
                        return text;
                    }
                    break;
                default:
                    return text;
            }
            throw new FormatException(Shown(text) + " is not of type " + dataTypeRef);
        }

        private static object[] DecodeList(string code, JToken read, int depth)
        {
            var list = read as JArray;
            if (list == null || depth >= Deepest)
            {
                throw new FormatException(
                    "a value of type " + code + " is a JSON array, nested at most " + Deepest + " deep");
            }
            string itemCode = code.Substring(0, code.Length - 2);
            if (itemCode.EndsWith("[]"))
            {
                return list.Select(item => (object)DecodeList(itemCode, item, depth + 1)).ToArray();
            }
            Kind kind = KindOf(itemCode);
            if (list.Any(item => !Fits(kind == Kind.StreamStatus ? Kind.Text : kind, item)))
            {
                throw new FormatException("an item of the array is not of type " + itemCode);
            }
            return list.Select(item => kind == Kind.Number ? (double)item : ((JValue)item).Value).ToArray();
        }

        private static bool Fits(Kind kind, JToken item)
        {
            switch (kind)
            {
                case Kind.Integer:
                    return item.Type == JTokenType.Integer && ((JValue)item).Value is long;
                case Kind.Number:
                    return item.Type == JTokenType.Integer || (item.Type == JTokenType.Float && IsFinite((double)item));
                case Kind.Truth:
                    return item.Type == JTokenType.Boolean;
                case Kind.ComponentStatus:
                    return item.Type == JTokenType.String && IsNameOf<ComponentStatus>((string)item);
                case Kind.StreamStatus:
                    return item.Type == JTokenType.String && IsNameOf<StreamStatus>((string)item);
                default:
                    return item.Type == JTokenType.String;
            }
        }

        private static bool IsFinite(double number)
        {
            return !double.IsNaN(number) && !double.IsInfinity(number);
        }

        private static JToken Plain(object value, int depth)
        {
            if (value is string)
            {
                return new JValue((string)value);
            }
            if (value is DateTimeOffset)
            {
                return new JValue(((DateTimeOffset)value).ToString("o", CultureInfo.InvariantCulture));
            }
            if (value is Enum)
            {
                return new JValue(RoISJson.NameOf(value));
            }
            var list = value as IEnumerable;
            if (list != null && depth <= Deepest)
            {
                return new JArray(list.Cast<object>().Select(item => Plain(item, depth + 1)));
            }
            if (value is int || value is short || value is byte)
            {
                return new JValue(Convert.ToInt64(value));
            }
            if (value is float)
            {
                return new JValue((double)(float)value);
            }
            if (value is bool || value is long || value is double)
            {
                return new JValue(value);
            }
            throw new FormatException(Shown(Convert.ToString(value)) + " is nothing that a value can be");
        }

        private static bool IsNameOf<T>(string text)
        {
            return Enum.GetValues(typeof(T)).Cast<object>().Any(member => RoISJson.NameOf(member) == text);
        }

        private static string Shown(string text)
        {
            return JsonConvert.ToString(text.Substring(0, Math.Min(text.Length, 80)));
        }
    }

    /// <summary>What a command or a change of parameters takes, by name.</summary>
    public sealed class Arguments
    {
        internal readonly List<Argument> List = new List<Argument>();

        /// <summary>Adds a value; null is not sent.</summary>
        /// <exception cref="BadParameterException">it does not fit its type</exception>
        public Arguments Add(string name, string dataTypeRef, object value)
        {
            if (value != null)
            {
                List.Add(new Argument { Name = name, DataTypeRef = dataTypeRef, Value = Encode(name, dataTypeRef, value) });
            }
            return this;
        }

        private static string Encode(string name, string dataTypeRef, object value)
        {
            try
            {
                return Values.Encode(dataTypeRef, value);
            }
            catch (FormatException error)
            {
                throw new BadParameterException(name + ": " + error.Message);
            }
        }
    }
}
