// Copyright the OpenRoIS authors. Apache-2.0.
using System.Text.RegularExpressions;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;

namespace OpenRoIS
{
    /// <summary>
    /// Reads JSON as RFC 8259 has it, and no more: Newtonsoft's reader takes single quotes, comments and other numbers, too.
    /// </summary>
    internal static class StrictJson
    {
        private static readonly Regex Token = new Regex(
            "\\G[ \\t\\r\\n]*(?:(?<value>\"(?:[^\"\\\\\\x00-\\x1f]|\\\\(?:[\"\\\\/bfnrt]|u[0-9a-fA-F]{4}))*\""
            + "|-?(?:0|[1-9][0-9]*)(?:\\.[0-9]+)?(?:[eE][+-]?[0-9]+)?|true|false|null)|(?<mark>[\\[\\]{},:]))");

        private static readonly Regex End = new Regex("\\G[ \\t\\r\\n]*\\z");

        /// <exception cref="JsonException">it is none</exception>
        internal static JToken Parse(string text)
        {
            int at = 0;
            // Newtonsoft sees to the order of marks and values, but for commas with nothing on one side.
            string before = "[";
            for (Match token = Token.Match(text); token.Success; token = Token.Match(text, at))
            {
                string mark = token.Groups["mark"].Value;
                bool isComma = mark == ",";
                if ((isComma && (before == "," || before == "[" || before == "{"))
                    || (before == "," && (mark == "]" || mark == "}")))
                {
                    throw new JsonReaderException("a comma stands where there is nothing to divide");
                }
                before = mark;
                at = token.Index + token.Length;
            }
            if (!End.IsMatch(text, at))
            {
                throw new JsonReaderException("there is no value of JSON at " + at);
            }
            return JsonRpcMessage.Parse(text);
        }
    }
}
