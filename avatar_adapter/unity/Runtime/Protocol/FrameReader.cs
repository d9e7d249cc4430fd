using System;

namespace OpenRoIS.Link
{
    /// <summary>
    /// Turns the bytes of the adapter into messages; after a LinkException the connection is beyond repair.
    /// </summary>
    internal sealed class FrameReader
    {
        private readonly byte[] _buffer = new byte[Wire.Header + Wire.MaxPayload];
        private int _begin;
        private int _end;
        private bool _greeted;

        /// <summary>Where the next bytes belong; never empty after TryTake has returned false.</summary>
        internal ArraySegment<byte> Free
        {
            get { return new ArraySegment<byte>(_buffer, _end, _buffer.Length - _end); }
        }

        /// <summary>Note that so many bytes were written to Free.</summary>
        internal void Filled(int count)
        {
            _end += count;
        }

        /// <summary>The next whole message: a Welcome, Bye, Command or Heard.</summary>
        internal bool TryTake(out object message)
        {
            message = null;
            if (_end - _begin >= Wire.Header)
            {
                MessageType type = ReadHeader();
                int length = (int)Wire.UInt32(_buffer, _begin + 8);
                if (_end - _begin >= Wire.Header + length)
                {
                    byte[] payload = new byte[length];
                    Buffer.BlockCopy(_buffer, _begin + Wire.Header, payload, 0, length);
                    _begin += Wire.Header + length;
                    message = Read(type, payload);
                    return true;
                }
            }
            Buffer.BlockCopy(_buffer, _begin, _buffer, 0, _end - _begin);
            _end -= _begin;
            _begin = 0;
            return false;
        }

        private MessageType ReadHeader()
        {
            if (!Wire.HasMagic(_buffer, _begin))
            {
                throw new LinkException("bad magic: this is not the engine link, or its framing is lost");
            }
            byte version = _buffer[_begin + 5];
            if (version != Wire.Version)
            {
                throw new LinkException($"version {version} is not spoken here, only {Wire.Version}");
            }
            bool flags = _buffer[_begin + 6] != 0 || _buffer[_begin + 7] != 0;
            if (flags || Wire.UInt32(_buffer, _begin + 12) != 0)
            {
                throw new LinkException("unknown flags in the header");
            }
            MessageType type = (MessageType)_buffer[_begin + 4];
            if (!Enum.IsDefined(typeof(MessageType), type))
            {
                throw new LinkException($"unknown message type {(int)type}");
            }
            if (!IsExpected(type))
            {
                throw new LinkException($"{Wire.Name(type)} is not expected here");
            }
            uint length = Wire.UInt32(_buffer, _begin + 8);
            if (length > Wire.MaxPayload)
            {
                throw new LinkException($"{Wire.Name(type)} of {length} bytes is over the limit of {Wire.MaxPayload}");
            }
            return type;
        }

        private bool IsExpected(MessageType type)
        {
            return type == MessageType.Bye
                || (_greeted ? type == MessageType.Command || type == MessageType.Audio : type == MessageType.Welcome);
        }

        private object Read(MessageType type, byte[] payload)
        {
            try
            {
                switch (type)
                {
                    case MessageType.Audio:
                        return Heard.Read(payload);
                    case MessageType.Command:
                        return Command.Read(Wire.ReadJson(payload));
                    case MessageType.Bye:
                        return new Bye(Member.Text(Wire.ReadJson(payload)["reason"], "reason", Member.MaxText));
                    default:
                        Welcome welcome = new Welcome(Wire.ReadJson(payload));
                        _greeted = true;
                        return welcome;
                }
            }
            catch (LinkException error)
            {
                throw new LinkException($"bad {Wire.Name(type)}: {error.Message}", error);
            }
        }
    }

    /// <summary>The adapter closes the connection, for this reason.</summary>
    internal sealed class Bye
    {
        internal readonly string Reason;

        internal Bye(string reason)
        {
            Reason = reason;
        }
    }
}
