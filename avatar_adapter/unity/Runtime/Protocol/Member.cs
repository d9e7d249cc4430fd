using System;
using Newtonsoft.Json.Linq;

namespace OpenRoIS.Link
{
    /// <summary>Reads the members of a message; what is wrong is a LinkException that names the member.</summary>
    internal static class Member
    {
        internal const int MaxName = 200;
        internal const int MaxText = 4000;

        internal static string Text(JToken value, string name, int limit)
        {
            if (value == null || value.Type != JTokenType.String)
            {
                throw new LinkException(name + ": expected a string");
            }
            string text = (string)value;
            int characters = 0;
            for (int index = 0; index < text.Length; index++, characters++)
            {
                if (char.IsSurrogatePair(text, index))
                {
                    index++;
                }
                else if (char.IsSurrogate(text[index]))
                {
                    throw new LinkException(name + ": half of a surrogate pair");
                }
            }
            if (characters > limit)
            {
                throw new LinkException($"{name}: longer than {limit} characters");
            }
            return text;
        }

        internal static long Integer(JToken value, string name, long low, long high)
        {
            long number = 0;
            bool fits = value != null && value.Type == JTokenType.Integer && TryInteger((JValue)value, out number);
            if (!fits || number < low || number > high)
            {
                throw new LinkException($"{name}: expected an integer from {low} to {high}");
            }
            return number;
        }

        internal static double Real(JToken value, string name, double low, double high)
        {
            double number = double.NaN;
            if (value != null && (value.Type == JTokenType.Float || value.Type == JTokenType.Integer))
            {
                number = (double)value;
            }
            // Not a number is neither.
            if (!(number >= low && number <= high))
            {
                throw new LinkException($"{name}: expected a number from {low:g} to {high:g}");
            }
            return number;
        }

        internal static JObject Mapping(JToken value, string name)
        {
            JObject mapping = value as JObject;
            if (mapping == null)
            {
                throw new LinkException(name + ": expected an object");
            }
            return mapping;
        }

        internal static JArray Array(JToken value, string name, int most)
        {
            JArray array = value as JArray;
            if (array == null || array.Count > most)
            {
                throw new LinkException($"{name}: expected an array of at most {most} items");
            }
            return array;
        }

        internal static bool IsNull(JToken value)
        {
            return value == null || value.Type == JTokenType.Null;
        }

        private static bool TryInteger(JValue value, out long number)
        {
            try
            {
                number = Convert.ToInt64(value.Value);
                return true;
            }
            catch (Exception error) when (error is OverflowException || error is InvalidCastException)
            {
                // Larger than 64 bits.
                number = 0;
                return false;
            }
        }
    }
}
