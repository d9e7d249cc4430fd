using System;

namespace OpenRoIS.Link
{
    /// <summary>
    /// What a LinkClient hands to its program: a Command, Heard, Connected, Disconnected or NotConnected.
    /// </summary>
    public abstract class Notice
    {
        internal Notice()
        {
        }
    }

    /// <summary>The adapter is there. All that is sent from now on goes to it.</summary>
    public sealed class Connected : Notice
    {
        internal Connected(LinkConnection connection)
        {
            Connection = connection;
        }

        /// <summary>What the adapter calls itself.</summary>
        public string Adapter
        {
            get { return Connection.Welcome.Name; }
        }

        /// <summary>Whether pictures go through shared memory.</summary>
        public bool HasRing
        {
            get { return Connection.HasRing; }
        }

        internal LinkConnection Connection { get; }
    }

    /// <summary>The adapter is gone; what it had asked for needs no answer any more.</summary>
    public sealed class Disconnected : Notice
    {
        internal Disconnected(LinkConnection connection, LinkException cause)
        {
            Connection = connection;
            Cause = cause;
        }

        /// <summary>Why, for a person.</summary>
        public string Reason
        {
            get { return Cause.Message; }
        }

        /// <summary>Why.</summary>
        public LinkException Cause { get; }

        internal LinkConnection Connection { get; }
    }

    /// <summary>An attempt to connect has failed; the next one follows.</summary>
    public sealed class NotConnected : Notice
    {
        internal NotConnected(LinkException cause)
        {
            Cause = cause;
        }

        /// <summary>Why, for a person.</summary>
        public string Reason
        {
            get { return Cause.Message; }
        }

        /// <summary>Why.</summary>
        public LinkException Cause { get; }
    }

    /// <summary>The operator's voice: 48 kHz, to be heard from that moment on.</summary>
    public sealed class Heard : Notice
    {
        /// <summary>Channels in turn.</summary>
        public readonly short[] Samples;
        public readonly int Channels;
        public readonly long TimestampNs;

        private Heard(short[] samples, int channels, long timestampNs)
        {
            Samples = samples;
            Channels = channels;
            TimestampNs = timestampNs;
        }

        /// <summary>Read the payload of AUDIO.</summary>
        internal static Heard Read(byte[] payload)
        {
            if (payload.Length < Wire.AudioHead)
            {
                throw new LinkException("shorter than its header");
            }
            uint channels = Wire.UInt32(payload, 16);
            int bytes = payload.Length - Wire.AudioHead;
            if (Wire.UInt32(payload, 20) != 0)
            {
                throw new LinkException("unknown flags");
            }
            if (channels < 1 || channels > 2)
            {
                throw new LinkException("channels from 1 to 2 expected");
            }
            if (bytes % (2 * (int)channels) != 0)
            {
                throw new LinkException("the last sample is not whole");
            }
            short[] samples = new short[bytes / 2];
            for (int index = 0; index < samples.Length; index++)
            {
                int at = Wire.AudioHead + 2 * index;
                samples[index] = (short)(payload[at] | payload[at + 1] << 8);
            }
            return new Heard(samples, (int)channels, (long)Wire.UInt64(payload, 8));
        }
    }
}
