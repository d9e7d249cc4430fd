// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.IO;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;

namespace OpenRoIS
{
    /// <summary>What a message of JSON-RPC 2.0 is.</summary>
    internal enum JsonRpcKind
    {
        Request,
        Notification,
        Response,
        Error,

        /// <summary>It is no message; <see cref="JsonRpcMessage.Wrong"/> says why.</summary>
        Violation
    }

    /// <summary>A message of JSON-RPC 2.0, read or to be written. Batches are none: the wire has none.</summary>
    internal sealed class JsonRpcMessage
    {
        internal const int ParseError = -32700;
        internal const int InvalidRequest = -32600;
        internal const int MethodNotFound = -32601;
        internal const int InvalidParams = -32602;
        internal const int InternalError = -32603;

        private const int Deepest = 128;

        internal JsonRpcKind Kind { get; private set; }

        /// <summary>Text, a number or null.</summary>
        internal JToken Id { get; private set; }

        internal string Method { get; private set; }

        internal JObject Params { get; private set; }

        internal JToken Result { get; private set; }

        internal RpcException Error { get; private set; }

        internal string Wrong { get; private set; }

        /// <summary>The code with which a violation is answered; 0 where it must not be.</summary>
        internal int WrongCode { get; private set; }

        /// <summary>Reads one message. Never throws, whatever the text holds.</summary>
        internal static JsonRpcMessage Read(string text)
        {
            JToken read;
            try
            {
                read = Parse(text);
            }
            catch (JsonException)
            {
                return Violation("the message is not JSON", ParseError, null);
            }
            var message = read as JObject;
            if (message == null)
            {
                return Violation("a message is one JSON object", InvalidRequest, null);
            }
            JToken id = message["id"];
            if (id != null && id.Type != JTokenType.String && id.Type != JTokenType.Integer
                && id.Type != JTokenType.Float && id.Type != JTokenType.Null)
            {
                return Violation("id must be a string, a number or null", InvalidRequest, null);
            }
            if (TextOf(message["jsonrpc"]) != "2.0")
            {
                return Violation("jsonrpc must be \"2.0\"", InvalidRequest, id);
            }
            return message["method"] != null ? ReadCall(message, id) : ReadAnswer(message, id);
        }

        /// <summary>Reads any JSON; dates stay texts.</summary>
        /// <exception cref="JsonException">it is none</exception>
        internal static JToken Parse(string text)
        {
            try
            {
                return ReadToEnd(text);
            }
            catch (Exception error) when (error is FormatException || error is OverflowException)
            {
                // Older versions of the reader let these of a number or an escape pass.
                throw new JsonReaderException(error.Message, error);
            }
        }

        private static JToken ReadToEnd(string text)
        {
            using (var reader = new JsonTextReader(new StringReader(text)))
            {
                reader.DateParseHandling = DateParseHandling.None;
                reader.MaxDepth = Deepest;
                JToken read = JToken.ReadFrom(reader);
                if (reader.Read())
                {
                    throw new JsonReaderException("there is more behind the value");
                }
                return read;
            }
        }

        internal static string WriteRequest(long id, string method, JObject given)
        {
            return Write(new JProperty("id", id), new JProperty("method", method), new JProperty("params", given));
        }

        internal static string WriteNotification(string method, JObject given)
        {
            return Write(new JProperty("method", method), new JProperty("params", given));
        }

        internal static string WriteResponse(JToken id, JToken result)
        {
            return Write(new JProperty("id", id), new JProperty("result", result));
        }

        internal static string WriteError(JToken id, int code, string message)
        {
            var error = new JObject(new JProperty("code", code), new JProperty("message", message));
            return Write(new JProperty("id", id), new JProperty("error", error));
        }

        private static string Write(params JProperty[] members)
        {
            var message = new JObject(new JProperty("jsonrpc", "2.0"));
            foreach (JProperty member in members)
            {
                message.Add(member);
            }
            return message.ToString(Formatting.None);
        }

        private static JsonRpcMessage ReadCall(JObject message, JToken id)
        {
            string method = TextOf(message["method"]);
            if (method == null)
            {
                return Violation("method must be a string", InvalidRequest, id);
            }
            JToken given = message["params"] ?? new JObject();
            if (given.Type == JTokenType.Null)
            {
                given = new JObject();
            }
            bool isRequest = message["id"] != null;
            if (!(given is JObject))
            {
                return Violation("params must be an object", isRequest ? InvalidParams : 0, id);
            }
            return new JsonRpcMessage
            {
                Kind = isRequest ? JsonRpcKind.Request : JsonRpcKind.Notification,
                Id = id,
                Method = method,
                Params = (JObject)given
            };
        }

        private static JsonRpcMessage ReadAnswer(JObject message, JToken id)
        {
            JToken result = message["result"];
            JToken error = message["error"];
            if (result == null && error == null)
            {
                return Violation("neither a request nor a response", InvalidRequest, id);
            }
            if (error == null)
            {
                return new JsonRpcMessage { Kind = JsonRpcKind.Response, Id = id, Result = result };
            }
            return new JsonRpcMessage { Kind = JsonRpcKind.Error, Id = id, Error = ReadError(error as JObject) };
        }

        private static RpcException ReadError(JObject error)
        {
            string message = error == null ? null : TextOf(error["message"]);
            JToken code = error == null ? null : error["code"];
            if (message == null || !((code as JValue)?.Value is long))
            {
                return new RpcException(InvalidRequest, "the answer's error object is malformed", null);
            }
            return new RpcException((long)code, message, error["data"]);
        }

        private static JsonRpcMessage Violation(string wrong, int code, JToken id)
        {
            return new JsonRpcMessage { Kind = JsonRpcKind.Violation, Wrong = wrong, WrongCode = code, Id = id };
        }

        private static string TextOf(JToken token)
        {
            return token != null && token.Type == JTokenType.String ? (string)token : null;
        }
    }
}
