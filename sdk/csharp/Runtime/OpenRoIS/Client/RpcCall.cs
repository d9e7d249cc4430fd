// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Text.RegularExpressions;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;

namespace OpenRoIS
{
    /// <summary>One request to a gateway: a result whose code is OK is a value, everything else an exception.</summary>
    internal static class RpcCall
    {
        private const int LongestAbout = 200;
        private const int LongestReason = 500;

        private static readonly string[] Names =
            { "component_ref", "query_type", "event_type", "event_id", "command_id", "stream_id", "condition" };

        /// <param name="session">the connection</param>
        /// <param name="method">what is called</param>
        /// <param name="given">its params</param>
        /// <param name="within">milliseconds to wait at most</param>
        /// <param name="token">ends the wait</param>
        /// <param name="accepted">takes a result that is OK before any later message is read</param>
        /// <param name="tooLate">takes a result that is OK and for which nothing waits any more</param>
        internal static async Task<TResult> AskAsync<TParams, TResult>(
            JsonRpcSession session,
            Method<TParams, TResult> method,
            TParams given,
            long within,
            CancellationToken token,
            Action<TResult> accepted = null,
            Action<TResult> tooLate = null)
            where TResult : class, IOutcome
        {
            JObject written = RoISJson.ToObject(given);
            TResult result = null;
            Action<JToken> late = null;
            if (tooLate != null)
            {
                late = raw => TakeLate(method, raw, tooLate);
            }
            await session.RequestAsync(
                method.Name,
                written,
                within,
                token,
                (raw, reason) =>
                {
                    result = Read(method, raw, About(written), reason);
                    accepted?.Invoke(result);
                },
                late);
            return result;
        }

        /// <summary>Reads a notification, or returns null where it is none of this type.</summary>
        internal static T ReadNotification<T>(JObject given)
            where T : class
        {
            try
            {
                return RoISJson.Known<T>(given);
            }
            catch (JsonException)
            {
                return null;
            }
        }

        /// <summary>Cleans a reason, which may be any text.</summary>
        internal static string OneLine(string text)
        {
            string cut = text.Substring(0, Math.Min(text.Length, LongestReason));
            return Regex.Replace(cut, @"[\s\p{C}]+", " ").Trim();
        }

        private static void TakeLate<TParams, TResult>(
            Method<TParams, TResult> method, JToken raw, Action<TResult> tooLate)
            where TResult : class, IOutcome
        {
            TResult result;
            try
            {
                result = Read(method, raw, "", "");
            }
            catch (Exception)
            {
                // It was refused: there is nothing to undo.
                return;
            }
            tooLate(result);
        }

        private static TResult Read<TParams, TResult>(
            Method<TParams, TResult> method, JToken raw, string about, string reason)
            where TResult : class, IOutcome
        {
            TResult result;
            try
            {
                result = RoISJson.Known<TResult>(raw);
            }
            catch (JsonException error)
            {
                throw new RpcException(
                    JsonRpcMessage.InvalidRequest, "the answer to " + method.Name + " cannot be read: " + error.Message);
            }
            if (result.ReturnCode != ReturnCode.Ok)
            {
                string code = RoISJson.NameOf(result.ReturnCode);
                string why = reason == "" ? "" : " (" + reason + ")";
                throw RoISException.Of(result.ReturnCode, method.Name + about + ": " + code + why, reason);
            }
            return result;
        }

        /// <summary>What was asked, as in a call: <c>(start of robot/navigation)</c>; empty without such names.</summary>
        private static string About(JObject given)
        {
            IEnumerable<string> named = Names.Select(name => (string)given[name]).Where(text => !string.IsNullOrEmpty(text));
            var sequence = given["command_unit_list"] as JArray;
            if (sequence != null)
            {
                named = sequence.SelectMany(item => item["command_list"] ?? new JArray(item))
                    .Select(unit => unit["command_type"] + " of " + unit["component_ref"]);
            }
            string about = string.Join(", ", named);
            return about == "" ? "" : "(" + about.Substring(0, Math.Min(about.Length, LongestAbout)) + ")";
        }
    }
}
