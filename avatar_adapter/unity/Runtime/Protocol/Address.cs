using System;
using System.Globalization;
using System.Net;
using System.Net.Sockets;
using System.Text;
using System.Threading;

namespace OpenRoIS.Link
{
    /// <summary>Where the adapter listens: unix:/path or tcp:host:port.</summary>
    internal sealed class Address
    {
        private readonly string _text;
        private readonly string _path;
        private readonly string _host;
        private readonly int _port;

        /// <exception cref="LinkException">It has neither form.</exception>
        internal Address(string text)
        {
            _text = text ?? "";
            if (_text.StartsWith("unix:", StringComparison.Ordinal) && _text.Length > 5)
            {
                _path = _text.Substring(5);
                return;
            }
            int cut = _text.LastIndexOf(':');
            if (_text.StartsWith("tcp:", StringComparison.Ordinal) && cut > 4
                && int.TryParse(_text.Substring(cut + 1), NumberStyles.None, CultureInfo.InvariantCulture, out _port)
                && _port <= 65535)
            {
                _host = _text.Substring(4, cut - 4).TrimStart('[').TrimEnd(']');
                return;
            }
            throw new LinkException($"address: expected unix:/path or tcp:host:port, not '{_text}'");
        }

        /// <summary>A connected socket.</summary>
        /// <param name="timeout">Milliseconds.</param>
        /// <param name="opened">Gets the socket before it is connected, so that another thread can close it.</param>
        /// <exception cref="LinkException">No adapter answers there.</exception>
        internal Socket Connect(int timeout, Action<Socket> opened)
        {
            Socket socket = null;
            try
            {
                EndPoint end = _path != null ? new UnixEnd(_path) : (EndPoint)new IPEndPoint(Resolve(), _port);
                bool unix = _path != null;
                socket = new Socket(
                    end.AddressFamily, SocketType.Stream, unix ? ProtocolType.Unspecified : ProtocolType.Tcp);
                opened(socket);
                IAsyncResult connecting = socket.BeginConnect(end, null, null);
                if (!connecting.AsyncWaitHandle.WaitOne(timeout))
                {
                    throw new LinkException($"cannot connect to {_text}: no adapter answers");
                }
                socket.EndConnect(connecting);
                if (!unix)
                {
                    socket.NoDelay = true;
                }
                return socket;
            }
            catch (Exception error)
            {
                socket?.Close();
                throw error as LinkException ?? new LinkException($"cannot connect to {_text}: {error.Message}", error);
            }
        }

        private IPAddress Resolve()
        {
            IPAddress address;
            return IPAddress.TryParse(_host, out address) ? address : Dns.GetHostAddresses(_host)[0];
        }

        /// <summary>A socket in the file system. .NET has this class from Standard 2.1 on only.</summary>
        private sealed class UnixEnd : EndPoint
        {
            private const int Family = 2;
            private const int Longest = 107;
            private readonly byte[] _path;

            internal UnixEnd(string path)
            {
                _path = Encoding.UTF8.GetBytes(path);
                if (_path.Length > Longest)
                {
                    throw new LinkException($"address: a path of a socket has at most {Longest} bytes");
                }
            }

            public override AddressFamily AddressFamily
            {
                get { return AddressFamily.Unix; }
            }

            public override SocketAddress Serialize()
            {
                SocketAddress address = new SocketAddress(AddressFamily.Unix, Family + _path.Length + 1);
                for (int index = 0; index < _path.Length; index++)
                {
                    address[Family + index] = _path[index];
                }
                address[Family + _path.Length] = 0;
                return address;
            }

            public override EndPoint Create(SocketAddress address)
            {
                return this;
            }
        }
    }
}
