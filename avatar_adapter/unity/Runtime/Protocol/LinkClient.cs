using System;
using System.Collections.Generic;
using System.Net.Sockets;
using System.Threading;

namespace OpenRoIS.Link
{
    /// <summary>
    /// The game engine's side of the engine link. It connects by itself, again whenever the adapter went away, and no
    /// call but Close waits for anything. Call TryTake in each frame until it returns false: what it returns is what
    /// happened, and what is sent goes to the adapter of the last Connected that it has returned.
    /// </summary>
    public sealed unsafe class LinkClient : IDisposable
    {
        /// <summary>Milliseconds between two attempts: doubled from the first to the longest.</summary>
        private const int FirstDelay = 500;
        private const int LongestDelay = 5000;

        /// <summary>Nanoseconds between two signs of life while no pictures are wanted.</summary>
        private const long SignEvery = 500000000;

        private readonly Address _address;
        private readonly Hello _hello;
        private readonly MonotonicClock _clock = new MonotonicClock();
        private readonly Inbox _inbox = new Inbox();
        private readonly object _state = new object();
        private readonly Dictionary<Told, byte[]> _told = new Dictionary<Told, byte[]>();
        private readonly Thread _thread;

        /// <summary>The connection that the program knows of.</summary>
        private volatile LinkConnection _current;

        /// <summary>The connection that there is, and the socket of it or of the attempt.</summary>
        private LinkConnection _newest;
        private Socket _socket;
        private bool _closed;
        private volatile bool _wanted = true;
        private long _wantedNs;
        private long _signedNs;

        /// <param name="address">unix:/path or tcp:host:port.</param>
        /// <param name="hello">What the engine says of itself; must not be changed any more.</param>
        /// <exception cref="LinkException">The address is malformed.</exception>
        public LinkClient(string address, Hello hello)
        {
            _address = new Address(address);
            _hello = hello;
            _thread = new Thread(Run) { IsBackground = true, Name = "OpenRoIS link" };
        }

        /// <summary>Whether an adapter is there, as far as TryTake has told.</summary>
        public bool IsConnected
        {
            get { return _current != null; }
        }

        /// <summary>Now, on the adapter's clock, in nanoseconds. From any thread.</summary>
        public long Now
        {
            get { return _clock.Now; }
        }

        /// <summary>
        /// Whether pictures are wanted: while they are not, draw none. Those that are sent all the same are left out.
        /// </summary>
        public bool PicturesWanted
        {
            get { return _wanted; }
        }

        /// <summary>Begin to connect.</summary>
        public void Start()
        {
            _thread.Start();
        }

        /// <summary>The next thing that happened, false if there is none. Of one thread.</summary>
        public bool TryTake(out Notice notice)
        {
            if (!_inbox.TryTake(out notice))
            {
                SignOfLife();
                return false;
            }
            Connected connected = notice as Connected;
            Demand demand = notice as Demand;
            if (connected != null)
            {
                TellAgain(connected.Connection);
                _current = connected.Connection;
            }
            else if (notice is Disconnected)
            {
                _current = null;
                _wanted = true;
                Volatile.Write(ref _wantedNs, 0);
            }
            else if (demand != null)
            {
                Heed(demand);
            }
            return true;
        }

        /// <summary>
        /// Send a picture; one that still waits gives way. The pixels are copied before this returns.
        /// </summary>
        /// <param name="pixels">As many bytes as the shape says.</param>
        /// <param name="shape">How they are laid out.</param>
        /// <param name="timestampNs">The moment that the picture shows, as of Now.</param>
        /// <returns>False if no adapter is there, or no picture is wanted.</returns>
        /// <exception cref="LinkException">The shape does not describe the pixels.</exception>
        public bool SendPicture(byte[] pixels, Picture shape, long timestampNs)
        {
            fixed (byte* at = pixels)
            {
                return SendPicture((IntPtr)at, pixels.Length, shape, timestampNs);
            }
        }

        /// <summary>Send a picture that is anywhere in memory.</summary>
        public bool SendPicture(IntPtr pixels, int size, Picture shape, long timestampNs)
        {
            if (_hello.Encodes)
            {
                throw new LinkException("HELLO announced encoded pictures, and this one is not");
            }
            if (size != shape.Size || size == 0)
            {
                throw new LinkException($"{shape.Size} bytes of pixels expected, {size} found");
            }
            LinkConnection connection = _current;
            return connection != null && IsWanted(timestampNs) && connection.SendPicture((byte*)pixels, shape, timestampNs);
        }

        /// <summary>
        /// Send a picture that was encoded here, if Hello.Encodes: an H.264 access unit in Annex B form, constrained
        /// baseline; key frames are IDR pictures with SPS and PPS before them. Sent in order, and all of them.
        /// </summary>
        /// <returns>False if some were lost: the next one has to be a key frame.</returns>
        /// <exception cref="LinkException">There is no such picture, or it is too large.</exception>
        public bool SendEncoded(byte[] data, int width, int height, long timestampNs, bool isKeyFrame)
        {
            if (!_hello.Encodes)
            {
                throw new LinkException("HELLO announced no encoded pictures");
            }
            Picture.CheckSides(width, height);
            if (data.Length == 0 || data.Length > Wire.MaxVideo - Wire.VideoHead)
            {
                throw new LinkException($"a picture of {data.Length} bytes");
            }
            LinkConnection connection = _current;
            bool sends = connection != null && IsWanted(timestampNs);
            return sends && connection.SendEncoded(data, width, height, timestampNs, isKeyFrame);
        }

        /// <summary>Send a block of sound: s16 at 48 kHz, channels in turn. From any thread.</summary>
        /// <param name="samples">Little-endian.</param>
        /// <param name="count">Bytes of them.</param>
        /// <param name="channels">1 or 2.</param>
        /// <param name="timestampNs">The moment to which the first sample belongs: count by samples.</param>
        /// <exception cref="LinkException">They are no whole samples, or more than the link takes.</exception>
        public void SendSound(byte[] samples, int count, int channels, long timestampNs)
        {
            bool fits = count >= 0 && count <= samples.Length && count <= Wire.MaxPayload - Wire.AudioHead;
            if (!fits || channels < 1 || channels > 2 || count % (2 * channels) != 0)
            {
                throw new LinkException($"a block of sound of {count} bytes in {channels} channels");
            }
            _current?.SendSound(samples, count, channels, timestampNs);
        }

        /// <summary>Something that was asked for is over.</summary>
        public void Completed(string id, Status status)
        {
            _current?.SendEvent(EventMessage.Completed(id, status));
        }

        /// <summary>The figure has reached that point of a Walk.</summary>
        public void Reached(string id, int index)
        {
            _current?.SendEvent(EventMessage.Reached(id, index));
        }

        /// <summary>A line for the adapter's log.</summary>
        public void Log(string text)
        {
            _current?.SendEvent(EventMessage.Log(text));
        }

        /// <summary>
        /// Where the figure is. Like all of the scene, to be told as often as you like, before connecting too.
        /// </summary>
        public void Place(double x, double y, double th)
        {
            Tell(Told.Place, EventMessage.Place(x, y, th));
        }

        /// <summary>Where the figure can go: inside the outline and outside the obstacles.</summary>
        public void Floor(IList<FloorPoint> outline, IList<IList<FloorPoint>> obstacles)
        {
            Tell(Told.Floor, EventMessage.Floor(outline, obstacles));
        }

        /// <summary>All there is beside the figure.</summary>
        public void Things(IList<Thing> things)
        {
            Tell(Told.Things, EventMessage.Things(things));
        }

        /// <summary>The engine pauses its pictures, or goes on.</summary>
        public void Pause(bool on)
        {
            Tell(Told.Pause, EventMessage.Pause(on));
        }

        /// <summary>Say goodbye and end for good; half a second at most.</summary>
        public void Close(string reason)
        {
            LinkConnection connection;
            lock (_state)
            {
                _closed = true;
                connection = _newest;
                if (connection == null)
                {
                    _socket?.Close();
                }
                Monitor.PulseAll(_state);
            }
            _inbox.Close();
            connection?.Close(EventMessage.Cut(reason));
            _current = null;
        }

        public void Dispose()
        {
            Close("the engine ends");
        }

        private void Heed(Demand demand)
        {
            bool wanted = demand.Consumers > 0 || !_hello.TakesDemand;
            if (wanted && !_wanted)
            {
                Volatile.Write(ref _wantedNs, Now);
            }
            _wanted = wanted;
        }

        /// <summary>Whether a picture of a moment is: one from before the demand may come late out of a read-back.</summary>
        private bool IsWanted(long timestampNs)
        {
            return _wanted && timestampNs >= Volatile.Read(ref _wantedNs);
        }

        /// <summary>Say that the engine lives while no picture shows it.</summary>
        private void SignOfLife()
        {
            if (!_wanted && Now - _signedNs >= SignEvery)
            {
                _signedNs = Now;
                _current?.SendEvent(EventMessage.Idle());
            }
        }

        private void Tell(Told kind, byte[] message)
        {
            lock (_told)
            {
                byte[] before;
                if (_told.TryGetValue(kind, out before) && AreSame(before, message))
                {
                    return;
                }
                _told[kind] = message;
                _current?.Outbox.Tell(kind, message);
            }
        }

        private void TellAgain(LinkConnection connection)
        {
            lock (_told)
            {
                foreach (KeyValuePair<Told, byte[]> told in _told)
                {
                    connection.Outbox.Tell(told.Key, told.Value);
                }
            }
        }

        private static bool AreSame(byte[] one, byte[] other)
        {
            if (one.Length != other.Length)
            {
                return false;
            }
            for (int index = 0; index < one.Length; index++)
            {
                if (one[index] != other[index])
                {
                    return false;
                }
            }
            return true;
        }

        private void Run()
        {
            int delay = FirstDelay;
            while (true)
            {
                delay = Visit() ? FirstDelay : delay;
                lock (_state)
                {
                    if (!_closed)
                    {
                        Monitor.Wait(_state, delay);
                    }
                    if (_closed)
                    {
                        return;
                    }
                }
                delay = Math.Min(2 * delay, LongestDelay);
            }
        }

        /// <summary>Connect once and read to the end; whether there was a welcome.</summary>
        private bool Visit()
        {
            LinkConnection connection;
            try
            {
                connection = LinkConnection.Open(_address, _hello, _clock, Opened);
            }
            catch (LinkException error)
            {
                _inbox.Put(new NotConnected(error));
                return false;
            }
            if (Begin(connection))
            {
                _inbox.Put(new Connected(connection));
            }
            try
            {
                connection.Read(_inbox.Put);
            }
            catch (LinkException error)
            {
                connection.Close(EventMessage.Cut(error.Message));
                _inbox.Put(new Disconnected(connection, error));
            }
            lock (_state)
            {
                _newest = null;
            }
            return true;
        }

        private void Opened(Socket socket)
        {
            lock (_state)
            {
                _socket = socket;
                if (_closed)
                {
                    socket.Close();
                }
            }
        }

        private bool Begin(LinkConnection connection)
        {
            lock (_state)
            {
                _newest = connection;
                if (_closed)
                {
                    connection.Dispose();
                }
                return !_closed;
            }
        }
    }
}
