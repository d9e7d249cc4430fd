using System;
using System.Net.Sockets;
using System.Threading;
using Newtonsoft.Json.Linq;

namespace OpenRoIS.Link
{
    /// <summary>One connection to an adapter: greeted by Open, read by one thread, written by another.</summary>
    internal sealed unsafe class LinkConnection : IDisposable
    {
        internal const int ConnectMs = 5000;
        internal const int GreetMs = 5000;

        /// <summary>An adapter that reads nothing for so long is gone.</summary>
        private const int StallMs = 10000;
        internal const int FarewellMs = 500;

        internal readonly Outbox Outbox = new Outbox();
        private readonly object _counting = new object();
        private readonly object _countingSound = new object();
        private readonly Socket _socket;
        private readonly FrameReader _reader = new FrameReader();
        private readonly Thread _writer;
        private RingWriter _ring;
        private ulong _pictures;
        private ulong _blocks;
        private volatile LinkException _failure;

        private LinkConnection(Socket socket)
        {
            _socket = socket;
            _writer = new Thread(Write) { IsBackground = true, Name = "OpenRoIS link writer" };
        }

        internal Welcome Welcome { get; private set; }

        internal bool HasRing
        {
            get { return _ring != null; }
        }

        /// <summary>Connect and greet; takes 10 s at most.</summary>
        /// <exception cref="LinkException">No adapter answers, it refuses, or it breaks the protocol.</exception>
        internal static LinkConnection Open(Address address, Hello hello, MonotonicClock clock, Action<Socket> opened)
        {
            Socket socket = address.Connect(ConnectMs, opened);
            LinkConnection connection = new LinkConnection(socket);
            try
            {
                if (socket.AddressFamily == AddressFamily.Unix)
                {
                    // One write takes a whole picture then. TCP finds its size by itself.
                    socket.SendBufferSize = hello.Width * hello.Height * 4;
                }
                socket.SendTimeout = StallMs;
                connection.Greet(hello, clock);
                socket.ReceiveTimeout = 0;
                connection._writer.Start();
                return connection;
            }
            catch (Exception error)
            {
                connection.Dispose();
                throw error as LinkException ?? new LinkException("no greeting: " + error.Message, error);
            }
        }

        /// <summary>Hand on all that comes; ends with an exception that says why.</summary>
        /// <exception cref="LinkException">The connection is over.</exception>
        internal void Read(Action<Notice> take)
        {
            try
            {
                while (true)
                {
                    Notice notice = Next() as Notice;
                    if (notice == null)
                    {
                        throw new LinkException("bad WELCOME: it came twice");
                    }
                    take(notice);
                }
            }
            catch (Exception error) when (!(error is LinkException))
            {
                // Sockets that are closed meanwhile throw all sorts of things; no game shall end of one.
                throw _failure ?? new LinkException("the connection broke: " + error.Message, error);
            }
        }

        /// <summary>Send a picture; false without a connection.</summary>
        internal bool SendPicture(byte* pixels, Picture shape, long timestampNs)
        {
            if (_failure != null)
            {
                return false;
            }
            // Pictures leave in the order of their numbers, from any thread.
            lock (_counting)
            {
                ulong sequence = _pictures++;
                int slot = _ring == null ? -1 : _ring.Write(sequence, pixels, shape.Size);
                Outbox.PutPicture(slot >= 0
                    ? Wire.Doorbell(sequence, timestampNs, shape, slot)
                    : Whole(sequence, timestampNs, shape, pixels));
            }
            return true;
        }

        /// <summary>Send an encoded picture; false if it or one before it is lost.</summary>
        internal bool SendEncoded(byte[] data, int width, int height, long timestampNs, bool isKeyFrame)
        {
            lock (_counting)
            {
                byte[] message = Wire.Encoded(_pictures++, timestampNs, width, height, isKeyFrame, data);
                return Outbox.PutEncoded(message, isKeyFrame);
            }
        }

        /// <summary>Send a block of sound.</summary>
        internal void SendSound(byte[] samples, int count, int channels, long timestampNs)
        {
            // Not the lock of the pictures: their copying would hold up the thread that mixes.
            lock (_countingSound)
            {
                Outbox.PutSound(Wire.Sound(_blocks++, timestampNs, channels, samples, count));
            }
        }

        /// <summary>Send an event; a connection on which too many wait is ended.</summary>
        internal bool SendEvent(byte[] message)
        {
            if (_failure != null)
            {
                return false;
            }
            if (!Outbox.PutEvent(message))
            {
                Fail(new LinkException("the adapter does not read: too many events wait"));
                return false;
            }
            return true;
        }

        /// <summary>Say goodbye and end; half a second at most.</summary>
        internal void Close(string reason)
        {
            Outbox.Finish(Wire.Json(MessageType.Bye, new JObject(new JProperty("reason", reason))));
            if (_writer.IsAlive)
            {
                _writer.Join(FarewellMs);
            }
            Fail(new LinkException(reason));
            Dispose();
        }

        public void Dispose()
        {
            Outbox.Abort();
            _socket.Close();
            _ring?.Dispose();
        }

        private void Greet(Hello hello, MonotonicClock clock)
        {
            SendAll(Wire.Json(MessageType.Hello, hello.ToJson()));
            _socket.ReceiveTimeout = GreetMs;
            Welcome = Next() as Welcome;
            if (Welcome == null)
            {
                throw new LinkException("refused");
            }
            if (Welcome.NowNs.HasValue)
            {
                clock.Set(Welcome.NowNs.Value, MonotonicClock.SystemNs());
            }
            if (Welcome.RingPath != null)
            {
                try
                {
                    _ring = new RingWriter(Welcome);
                }
                catch (LinkException error)
                {
                    SendEvent(EventMessage.Log(error.Message + "; pictures go through the socket"));
                }
            }
        }

        private object Next()
        {
            object message;
            while (!_reader.TryTake(out message))
            {
                ArraySegment<byte> free = _reader.Free;
                int count = _socket.Receive(free.Array, free.Offset, free.Count, SocketFlags.None);
                if (count == 0)
                {
                    throw _failure ?? new LinkException("the adapter closed the connection");
                }
                _reader.Filled(count);
            }
            Bye bye = message as Bye;
            if (bye != null)
            {
                throw new LinkException((Welcome == null ? "refused: " : "") + bye.Reason);
            }
            return message;
        }

        private byte[] Whole(ulong sequence, long timestampNs, Picture shape, byte* pixels)
        {
            int head = Wire.Header + Wire.VideoHead;
            byte[] message = Outbox.Rent(head + shape.Size);
            Wire.PutHeader(message, MessageType.Video, Wire.VideoHead + shape.Size);
            Wire.PutPicture(message, sequence, timestampNs, shape);
            fixed (byte* at = message)
            {
                Buffer.MemoryCopy(pixels, at + head, shape.Size, shape.Size);
            }
            return message;
        }

        private void Write()
        {
            try
            {
                byte[] message = null;
                while ((message = Outbox.Take(message)) != null)
                {
                    SendAll(message);
                }
            }
            catch (Exception error)
            {
                Fail(new LinkException("the connection broke: " + error.Message, error));
            }
        }

        private void SendAll(byte[] message)
        {
            int sent = 0;
            while (sent < message.Length)
            {
                sent += _socket.Send(message, sent, message.Length - sent, SocketFlags.None);
            }
        }

        /// <summary>Hang up, from any thread; the reader finds it.</summary>
        private void Fail(LinkException failure)
        {
            _failure = _failure ?? failure;
            Outbox.Abort();
            try
            {
                _socket.Shutdown(SocketShutdown.Both);
            }
            catch (Exception error) when (error is SocketException || error is ObjectDisposedException)
            {
                // It is down already.
            }
        }
    }
}
