using System.Collections.Generic;
using Newtonsoft.Json.Linq;

namespace OpenRoIS.Link
{
    /// <summary>What an engine says of itself when it connects; set before the client starts.</summary>
    public sealed class Hello
    {
        public string Name = "unity";
        public string Version = "";
        public string Secret = "";

        /// <summary>The pictures that will come.</summary>
        public int Width = 1280;
        public int Height = 720;
        public double PicturesPerSecond = 30.0;
        public PixelFormat Format = PixelFormat.Bgra;

        /// <summary>Whether the pictures come as H.264, whatever Format says: LinkClient.SendEncoded.</summary>
        public bool Encodes;

        /// <summary>Channels of the sound that will come, 0 for none.</summary>
        public int AudioChannels;

        /// <summary>Names of what the figure can play.</summary>
        public IList<string> Reactions = new List<string>();

        /// <summary>Whether it wants the operator's voice.</summary>
        public bool Hears;

        /// <summary>Whether it understands Walk, Drive and Halt, and tells its place.</summary>
        public bool Walks;

        /// <summary>Whether it wants a ring for its pictures.</summary>
        public bool Ring;

        /// <summary>Whether it takes Input.</summary>
        public bool TakesInput;

        /// <summary>Whether it draws nothing while no pictures are wanted: LinkClient.PicturesWanted.</summary>
        public bool TakesDemand;

        internal JObject ToJson()
        {
            JObject video = new JObject(
                new JProperty("width", Width),
                new JProperty("height", Height),
                new JProperty("fps", PicturesPerSecond),
                new JProperty("format", Encodes ? "h264" : Format.ToString().ToLowerInvariant()));
            JObject sound = AudioChannels == 0 ? null : new JObject(new JProperty("channels", AudioChannels));
            return new JObject(
                new JProperty("name", Name),
                new JProperty("version", Version),
                new JProperty("secret", Secret ?? ""),
                new JProperty("video", video),
                new JProperty("audio", sound),
                new JProperty("reactions", new JArray(Reactions)),
                new JProperty("hears", Hears),
                new JProperty("walks", Walks),
                new JProperty("ring", Ring && !Encodes),
                new JProperty("input", TakesInput),
                new JProperty("demand", TakesDemand));
        }
    }

    /// <summary>The adapter's answer to HELLO.</summary>
    internal sealed class Welcome
    {
        private const int MaxSlots = 64;
        private const int MaxSlot = 64 * 1024 * 1024;
        internal const int SlotHead = 64;

        internal readonly string Name;

        /// <summary>The adapter's clock when it said so, null if it does not tell.</summary>
        internal readonly long? NowNs;

        /// <summary>The file of the ring, null if there is none.</summary>
        internal readonly string RingPath;
        internal readonly int Slots;
        internal readonly int SlotBytes;

        internal Welcome(JObject body)
        {
            Name = Member.Text(body["name"], "name", Member.MaxName);
            if (body["now_ns"] != null)
            {
                NowNs = Member.Integer(body["now_ns"], "now_ns", 0, long.MaxValue);
            }
            if (!Member.IsNull(body["ring"]))
            {
                JObject ring = Member.Mapping(body["ring"], "ring");
                Slots = (int)Member.Integer(ring["slots"], "slots", 2, MaxSlots);
                SlotBytes = (int)Member.Integer(ring["slot_bytes"], "slot_bytes", SlotHead, MaxSlot);
                if (SlotBytes % SlotHead != 0)
                {
                    throw new LinkException($"slot_bytes: expected a multiple of {SlotHead}");
                }
                RingPath = Member.Text(ring["path"], "path", Member.MaxText);
            }
        }
    }
}
