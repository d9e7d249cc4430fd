using System;
using System.Globalization;
using System.IO;
using System.Text;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;

namespace OpenRoIS.Link
{
    internal enum MessageType : byte
    {
        Hello = 1,
        Welcome = 2,
        Video = 3,
        Audio = 4,
        Command = 5,
        Event = 6,
        Bye = 7,
        Ring = 8
    }

    /// <summary>The bytes of messages: a header of 16, and what follows it; all integers little-endian.</summary>
    internal static class Wire
    {
        internal const int Header = 16;
        internal const int VideoHead = 40;
        internal const int AudioHead = 24;
        internal const int RingSize = 48;
        internal const int MaxPayload = 64 * 1024;
        internal const int MaxVideo = 64 * 1024 * 1024;
        internal const byte Version = 1;

        private const uint H264 = 4;
        private const uint BottomUp = 1;
        private const uint KeyFrame = 2;
        private const int MaxDepth = 64;
        private static readonly byte[] Magic = { (byte)'O', (byte)'R', (byte)'L', (byte)'1' };
        private static readonly Encoding Outgoing = new UTF8Encoding(false, false);
        private static readonly Encoding Incoming = new UTF8Encoding(false, true);

        /// <summary>Write a header to the start of a message.</summary>
        internal static void PutHeader(byte[] message, MessageType type, int length)
        {
            Buffer.BlockCopy(Magic, 0, message, 0, 4);
            message[4] = (byte)type;
            message[5] = Version;
            message[6] = message[7] = 0;
            PutUInt32(message, 8, (uint)length);
            PutUInt32(message, 12, 0);
        }

        /// <summary>Write the 40 bytes that VIDEO and RING begin with, behind the header.</summary>
        internal static void PutPicture(byte[] message, ulong sequence, long timestampNs, Picture shape)
        {
            PutVideoHead(message, sequence, timestampNs, shape.Width, shape.Height, shape.Stride, (uint)shape.Format,
                shape.BottomUp ? BottomUp : 0);
        }

        /// <summary>A picture that was encoded.</summary>
        internal static byte[] Encoded(
            ulong sequence, long timestampNs, int width, int height, bool isKeyFrame, byte[] data)
        {
            byte[] message = new byte[Header + VideoHead + data.Length];
            PutHeader(message, MessageType.Video, VideoHead + data.Length);
            PutVideoHead(message, sequence, timestampNs, width, height, 0, H264, isKeyFrame ? KeyFrame : 0);
            Buffer.BlockCopy(data, 0, message, Header + VideoHead, data.Length);
            return message;
        }

        /// <summary>The doorbell of a picture that is in a slot of the ring.</summary>
        internal static byte[] Doorbell(ulong sequence, long timestampNs, Picture shape, int slot)
        {
            byte[] message = new byte[Header + RingSize];
            PutHeader(message, MessageType.Ring, RingSize);
            PutPicture(message, sequence, timestampNs, shape);
            PutUInt32(message, Header + VideoHead, (uint)slot);
            PutUInt32(message, Header + VideoHead + 4, 0);
            return message;
        }

        /// <summary>A block of sound whose samples are still to be written, behind header and head.</summary>
        internal static byte[] Sound(ulong sequence, long timestampNs, int channels, byte[] samples, int count)
        {
            byte[] message = new byte[Header + AudioHead + count];
            PutHeader(message, MessageType.Audio, AudioHead + count);
            PutUInt64(message, Header, sequence);
            PutUInt64(message, Header + 8, (ulong)timestampNs);
            PutUInt32(message, Header + 16, (uint)channels);
            PutUInt32(message, Header + 20, 0);
            Buffer.BlockCopy(samples, 0, message, Header + AudioHead, count);
            return message;
        }

        /// <summary>A whole message with a JSON object.</summary>
        internal static byte[] Json(MessageType type, JObject body)
        {
            byte[] payload = Outgoing.GetBytes(body.ToString(Formatting.None));
            if (payload.Length > MaxPayload)
            {
                throw new LinkException($"{Name(type)} of {payload.Length} bytes is over the limit of {MaxPayload}");
            }
            byte[] message = new byte[Header + payload.Length];
            PutHeader(message, type, payload.Length);
            Buffer.BlockCopy(payload, 0, message, Header, payload.Length);
            return message;
        }

        internal static JObject ReadJson(byte[] payload)
        {
            try
            {
                using (JsonTextReader reader = new JsonTextReader(new StringReader(Incoming.GetString(payload))))
                {
                    // A text that looks like a date stays a text.
                    reader.DateParseHandling = DateParseHandling.None;
                    reader.Culture = CultureInfo.InvariantCulture;
                    reader.MaxDepth = MaxDepth;
                    JToken body = JToken.ReadFrom(reader);
                    JObject found = body as JObject;
                    if (found == null || reader.Read())
                    {
                        throw new LinkException("the payload is not a JSON object");
                    }
                    return found;
                }
            }
            catch (Exception error) when (error is JsonException || error is ArgumentException
                || error is FormatException || error is OverflowException)
            {
                throw new LinkException("the payload is not JSON: " + error.Message, error);
            }
        }

        internal static string Name(MessageType type)
        {
            return type.ToString().ToUpperInvariant();
        }

        internal static bool HasMagic(byte[] at, int offset)
        {
            for (int index = 0; index < Magic.Length; index++)
            {
                if (at[offset + index] != Magic[index])
                {
                    return false;
                }
            }
            return true;
        }

        internal static uint UInt32(byte[] at, int offset)
        {
            return at[offset] | (uint)at[offset + 1] << 8 | (uint)at[offset + 2] << 16 | (uint)at[offset + 3] << 24;
        }

        internal static ulong UInt64(byte[] at, int offset)
        {
            return UInt32(at, offset) | (ulong)UInt32(at, offset + 4) << 32;
        }

        private static void PutVideoHead(byte[] message, ulong sequence, long timestampNs, int width, int height,
            int stride, uint format, uint flags)
        {
            PutUInt64(message, Header, sequence);
            PutUInt64(message, Header + 8, (ulong)timestampNs);
            PutUInt32(message, Header + 16, (uint)width);
            PutUInt32(message, Header + 20, (uint)height);
            PutUInt32(message, Header + 24, (uint)stride);
            PutUInt32(message, Header + 28, format);
            PutUInt32(message, Header + 32, flags);
            PutUInt32(message, Header + 36, 0);
        }

        private static void PutUInt32(byte[] at, int offset, uint value)
        {
            at[offset] = (byte)value;
            at[offset + 1] = (byte)(value >> 8);
            at[offset + 2] = (byte)(value >> 16);
            at[offset + 3] = (byte)(value >> 24);
        }

        private static void PutUInt64(byte[] at, int offset, ulong value)
        {
            PutUInt32(at, offset, (uint)value);
            PutUInt32(at, offset + 4, (uint)(value >> 32));
        }
    }
}
