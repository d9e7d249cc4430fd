// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.IO;
using System.Net.WebSockets;
using System.Text;
using System.Text.RegularExpressions;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>Connects by the platform's <see cref="ClientWebSocket"/>: everywhere but in a browser.</summary>
    public sealed class WebSocketTransport : ITransport
    {
        private static readonly Regex Status = new Regex(@"\b([45][0-9][0-9])\b");

        public async Task<IMessageSocket> OpenAsync(Uri address, string token, CancellationToken cancellation)
        {
            var socket = new ClientWebSocket();
            if (token != null)
            {
                socket.Options.SetRequestHeader("Authorization", "Bearer " + token);
            }
            try
            {
                await socket.ConnectAsync(address, cancellation);
            }
            catch (Exception error)
            {
                socket.Dispose();
                cancellation.ThrowIfCancellationRequested();
                throw Refusal(address, error);
            }
            return new Socket(socket);
        }

        private static ConnectionFailedException Refusal(Uri address, Exception error)
        {
            Exception inmost = error.GetBaseException();
            Match status = Status.Match(inmost.Message);
            switch (status.Success ? status.Value : "")
            {
                case "401":
                    return new ConnectionFailedException(
                        "the gateway at " + address + " wants a valid token: set ClientOptions.Token (401)", true);
                case "403":
                    return new ConnectionFailedException(
                        "the gateway at " + address + " does not let this application in: without tokens it answers its own "
                        + "machine alone, and with them the token needs a role of applications (403)", true);
                case "":
                    if (inmost is WebSocketException)
                    {
                        // What Mono and Unity throw has neither the status nor another reason.
                        return new ConnectionFailedException(
                            "what listens at " + address + " refuses this application, and the platform does not say with "
                            + "which status: a gateway may want a valid token (set ClientOptions.Token; its role must be one "
                            + "of applications), answer its own machine alone while it has no tokens, or be full");
                    }
                    goto default;
                default:
                    return new ConnectionFailedException("no connection to " + address + ": " + inmost.Message);
            }
        }

        private sealed class Socket : IMessageSocket
        {
            private const int Broken = 1006;
            private const int TooLong = 1009;
            private const int Binary = 1003;

            /// <summary>Bytes of a message; a gateway's are shorter.</summary>
            private const int Longest = 16 * 1024 * 1024;

            /// <summary>Milliseconds that the other side has to answer a close.</summary>
            private const int Farewell = 1000;

            private readonly ClientWebSocket _socket;
            private readonly byte[] _bytes = new byte[16 * 1024];
            private readonly TaskCompletionSource<bool> _ended =
                new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);

            internal Socket(ClientWebSocket socket)
            {
                _socket = socket;
                CloseCode = Broken;
                CloseReason = "";
            }

            public int CloseCode { get; private set; }

            public string CloseReason { get; private set; }

            public Task SendAsync(string text)
            {
                var bytes = new ArraySegment<byte>(Encoding.UTF8.GetBytes(text));
                return _socket.SendAsync(bytes, WebSocketMessageType.Text, true, CancellationToken.None);
            }

            public async Task<string> ReceiveAsync()
            {
                using (var message = new MemoryStream())
                {
                    while (true)
                    {
                        WebSocketReceiveResult part = await ReceivePartAsync();
                        if (part == null)
                        {
                            return null;
                        }
                        message.Write(_bytes, 0, part.Count);
                        if (part.MessageType == WebSocketMessageType.Binary || message.Length > Longest)
                        {
                            bool binary = part.MessageType == WebSocketMessageType.Binary;
                            _ended.TrySetResult(true);
                            await CloseAsync(binary ? Binary : TooLong, "");
                            return null;
                        }
                        if (part.EndOfMessage)
                        {
                            return Encoding.UTF8.GetString(message.GetBuffer(), 0, (int)message.Length);
                        }
                    }
                }
            }

            public async Task CloseAsync(int code, string reason)
            {
                if (CloseCode == Broken)
                {
                    CloseCode = code;
                    CloseReason = reason;
                }
                Task limit = Task.Delay(Farewell);
                try
                {
                    await Task.WhenAny(
                        _socket.CloseOutputAsync((WebSocketCloseStatus)code, reason, CancellationToken.None), limit);
                    await Task.WhenAny(_ended.Task, limit);
                }
                catch (Exception)
                {
                    // It is over already, in whichever way.
                }
                _socket.Abort();
            }

            public void Dispose()
            {
                _socket.Dispose();
            }

            private async Task<WebSocketReceiveResult> ReceivePartAsync()
            {
                try
                {
                    WebSocketReceiveResult part =
                        await _socket.ReceiveAsync(new ArraySegment<byte>(_bytes), CancellationToken.None);
                    if (part.MessageType != WebSocketMessageType.Close)
                    {
                        return part;
                    }
                    if (CloseCode == Broken)
                    {
                        CloseCode = (int)(part.CloseStatus ?? (WebSocketCloseStatus)1005);
                        CloseReason = part.CloseStatusDescription ?? "";
                    }
                    _ended.TrySetResult(true);
                    await CloseAsync(1000, "");
                }
                catch (Exception error)
                {
                    if (CloseCode == Broken)
                    {
                        CloseReason = error.GetBaseException().Message;
                    }
                    _ended.TrySetResult(true);
                }
                return null;
            }
        }
    }
}
