// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// Opens connections to a gateway. <see cref="WebSocketTransport"/> does in .NET and Mono; a browser (WebGL) has
    /// sockets of its own, for which an implementation of this stands in.
    /// </summary>
    public interface ITransport
    {
        /// <summary>Opens a WebSocket.</summary>
        /// <param name="address">the gateway, <c>ws</c> or <c>wss</c></param>
        /// <param name="token">goes into the header <c>Authorization: Bearer</c>; a browser cannot set it and offers the
        /// subprotocols <c>openrois.v1</c> and <c>openrois.bearer.</c> with the token behind it. Null for none</param>
        /// <param name="cancellation">ends the attempt</param>
        /// <exception cref="ConnectionFailedException">there is no gateway, or it refuses</exception>
        Task<IMessageSocket> OpenAsync(Uri address, string token, CancellationToken cancellation);
    }

    /// <summary>An open WebSocket with text messages.</summary>
    public interface IMessageSocket : IDisposable
    {
        /// <summary>The code with which it was closed (RFC 6455, 7.4); 1006 where it broke.</summary>
        int CloseCode { get; }

        /// <summary>The reason that came with the code, or how it broke; may be empty.</summary>
        string CloseReason { get; }

        /// <summary>Sends one message. There is one call at a time. Throws anything where the connection is over.</summary>
        Task SendAsync(string text);

        /// <summary>Returns the next message, null once the connection is over. There is one call at a time.</summary>
        Task<string> ReceiveAsync();

        /// <summary>Says why this side closes; <see cref="ReceiveAsync"/> returns null then. Throws nothing.</summary>
        Task CloseAsync(int code, string reason);
    }
}
