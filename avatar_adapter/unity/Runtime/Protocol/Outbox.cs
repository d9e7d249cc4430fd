using System;
using System.Collections.Generic;
using System.Threading;

namespace OpenRoIS.Link
{
    /// <summary>
    /// What is told of the scene: of each kind only the newest counts, and none comes oftener than its pace.
    /// </summary>
    internal enum Told
    {
        Floor,
        Place,
        Things,
        Pause
    }

    /// <summary>
    /// What still has to be sent: every event, the newest state of the scene, a little sound, the newest picture, in
    /// this order. The program fills it and never waits; one thread empties it.
    /// </summary>
    internal sealed class Outbox
    {
        internal const int MaxEvents = 256;
        internal const int MaxSound = 25;
        internal const int MaxEncoded = 8;
        private const int MaxSpare = 3;
        private const long NsPerMs = 1000000;

        private static readonly int Kinds = Enum.GetValues(typeof(Told)).Length;

        /// <summary>Milliseconds between two of a kind.</summary>
        private static readonly int[] Pace = { 0, 50, 100, 0 };

        private readonly object _changed = new object();
        private readonly Queue<byte[]> _events = new Queue<byte[]>();
        private readonly Queue<byte[]> _sound = new Queue<byte[]>();
        private readonly Queue<byte[]> _encoded = new Queue<byte[]>();
        private readonly Stack<byte[]> _spare = new Stack<byte[]>();
        private readonly byte[][] _told = new byte[Kinds][];
        private readonly long[] _toldAt = new long[Kinds];
        private byte[] _picture;
        private bool _hasShown;

        /// <summary>Whether an encoded picture was lost, and no key frame has come since.</summary>
        private bool _isBroken;
        private byte[] _farewell;
        private bool _aborted;

        /// <summary>Queue an event; false if there is no room or no connection.</summary>
        internal bool PutEvent(byte[] message)
        {
            lock (_changed)
            {
                if (!IsOpen || _events.Count >= MaxEvents)
                {
                    return false;
                }
                _events.Enqueue(message);
                Monitor.Pulse(_changed);
                return true;
            }
        }

        /// <summary>Set what is to be told of the scene.</summary>
        internal void Tell(Told kind, byte[] message)
        {
            lock (_changed)
            {
                if (IsOpen)
                {
                    _told[(int)kind] = message;
                    Monitor.Pulse(_changed);
                }
            }
        }

        /// <summary>Queue a block of sound; the oldest gives way.</summary>
        internal void PutSound(byte[] message)
        {
            lock (_changed)
            {
                if (!IsOpen)
                {
                    return;
                }
                if (_sound.Count >= MaxSound)
                {
                    _sound.Dequeue();
                }
                _sound.Enqueue(message);
                Monitor.Pulse(_changed);
            }
        }

        /// <summary>Memory for a message of this size with a picture.</summary>
        internal byte[] Rent(int size)
        {
            lock (_changed)
            {
                while (_spare.Count > 0)
                {
                    byte[] spare = _spare.Pop();
                    if (spare.Length == size)
                    {
                        return spare;
                    }
                }
            }
            return new byte[size];
        }

        /// <summary>
        /// Put a picture, or the doorbell of one; one that still waits gives way, but for the first of all: the adapter
        /// sees the count begin with it.
        /// </summary>
        internal void PutPicture(byte[] message)
        {
            lock (_changed)
            {
                if (!IsOpen)
                {
                    return;
                }
                if (_picture != null && !_hasShown)
                {
                    Keep(message);
                    return;
                }
                Keep(_picture);
                _picture = message;
                Monitor.Pulse(_changed);
            }
        }

        /// <summary>
        /// Queue an encoded picture; false if it, or those before it, were lost: only a key frame helps then.
        /// </summary>
        internal bool PutEncoded(byte[] message, bool isKeyFrame)
        {
            lock (_changed)
            {
                if (_encoded.Count >= MaxEncoded)
                {
                    _encoded.Clear();
                    _isBroken = true;
                }
                if (!IsOpen || (_isBroken && !isKeyFrame))
                {
                    return false;
                }
                _isBroken = false;
                _encoded.Enqueue(message);
                Monitor.Pulse(_changed);
                return true;
            }
        }

        /// <summary>The next message as soon as there is one; null when there will be none any more.</summary>
        /// <param name="sent">What was taken before, for the next picture of its size; null at first.</param>
        internal byte[] Take(byte[] sent)
        {
            lock (_changed)
            {
                Keep(sent);
                while (!_aborted)
                {
                    int wait;
                    byte[] message = Next(out wait);
                    if (message != null)
                    {
                        return message;
                    }
                    if (_farewell != null && _farewell.Length == 0)
                    {
                        return null;
                    }
                    Monitor.Wait(_changed, wait);
                }
                return null;
            }
        }

        /// <summary>End after the events that wait, and this message; sound and pictures are left out.</summary>
        internal void Finish(byte[] farewell)
        {
            lock (_changed)
            {
                if (IsOpen)
                {
                    _sound.Clear();
                    _encoded.Clear();
                    _picture = null;
                    _farewell = farewell;
                    Monitor.Pulse(_changed);
                }
            }
        }

        /// <summary>End now; what waits is lost.</summary>
        internal void Abort()
        {
            lock (_changed)
            {
                _aborted = true;
                Monitor.Pulse(_changed);
            }
        }

        private bool IsOpen
        {
            get { return !_aborted && _farewell == null; }
        }

        private byte[] Next(out int wait)
        {
            wait = Timeout.Infinite;
            if (_events.Count > 0)
            {
                return _events.Dequeue();
            }
            byte[] message = NextTold(ref wait);
            if (message != null)
            {
                return message;
            }
            if (_farewell != null)
            {
                // Nothing is an end that was said.
                message = _farewell.Length > 0 ? _farewell : null;
                _farewell = new byte[0];
                return message;
            }
            if (_sound.Count > 0)
            {
                return _sound.Dequeue();
            }
            if (_encoded.Count > 0)
            {
                return _encoded.Dequeue();
            }
            message = _picture;
            _picture = null;
            _hasShown |= message != null;
            return message;
        }

        private byte[] NextTold(ref int wait)
        {
            long now = MonotonicClock.SystemNs() / NsPerMs;
            for (int kind = 0; kind < Kinds; kind++)
            {
                byte[] message = _told[kind];
                if (message == null)
                {
                    continue;
                }
                long due = _toldAt[kind] == 0 || _farewell != null ? now : _toldAt[kind] + Pace[kind];
                if (due <= now)
                {
                    _told[kind] = null;
                    _toldAt[kind] = now;
                    return message;
                }
                wait = wait == Timeout.Infinite ? (int)(due - now) : Math.Min(wait, (int)(due - now));
            }
            return null;
        }

        private void Keep(byte[] message)
        {
            if (message != null && message.Length > Wire.Header + Wire.MaxPayload && _spare.Count < MaxSpare)
            {
                _spare.Push(message);
            }
        }
    }
}
