// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Linq;
using Newtonsoft.Json.Linq;

namespace OpenRoIS
{
    /// <summary>A JSON-RPC error: the other side does not know the method, or not with these params, or has failed.</summary>
    public sealed class RpcException : Exception
    {
        /// <param name="code">which kind of error it is (JSON-RPC 2.0, 5.1)</param>
        /// <param name="message">a sentence</param>
        /// <param name="data">more about it; may be null</param>
        public RpcException(long code, string message, JToken data = null)
            : base(message + " (" + code + ")" + Details(data))
        {
            Code = code;
            ErrorData = data;
        }

        /// <summary>The same, with the method that was asked.</summary>
        internal RpcException(string method, RpcException error)
            : base(method + ": " + error.Message)
        {
            Code = error.Code;
            ErrorData = error.ErrorData;
        }

        /// <summary>-32601 for an unknown method, -32602 for wrong params (JSON-RPC 2.0, 5.1).</summary>
        public long Code { get; private set; }

        /// <summary>What came with the error; null where nothing did.</summary>
        public JToken ErrorData { get; private set; }

        private static string Details(JToken data)
        {
            var wrong = data as JArray;
            if (wrong == null)
            {
                return "";
            }
            string said = string.Join("; ", wrong.OfType<JObject>().Take(3).Select(
                each => each["path"] + ": " + each["message"]));
            return said == "" ? "" : ": " + said.Substring(0, Math.Min(said.Length, 300));
        }
    }

    /// <summary>There is no connection, or it ended before the answer came.</summary>
    public sealed class ConnectionLostException : Exception
    {
        public ConnectionLostException(string message)
            : base(message)
        {
        }
    }

    /// <summary>There is no gateway, or it does not let this application in.</summary>
    public sealed class ConnectionFailedException : Exception
    {
        /// <param name="message">a sentence with the remedy</param>
        /// <param name="final">another attempt cannot help</param>
        public ConnectionFailedException(string message, bool final = false)
            : base(message)
        {
            Final = final;
        }

        /// <summary>Another attempt cannot help.</summary>
        public bool Final { get; private set; }
    }
}
