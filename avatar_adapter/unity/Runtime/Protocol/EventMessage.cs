using System;
using System.Collections.Generic;
using Newtonsoft.Json.Linq;

namespace OpenRoIS.Link
{
    /// <summary>How something ended that the adapter had asked for.</summary>
    public enum Status
    {
        /// <summary>Done to its end.</summary>
        Ok,

        /// <summary>Stopped before.</summary>
        Abort,

        /// <summary>Not possible.</summary>
        Error
    }

    /// <summary>A point on the floor, in metres: x right and y away from who looks at the picture.</summary>
    public struct FloorPoint
    {
        public readonly double X;
        public readonly double Y;

        public FloorPoint(double x, double y)
        {
            X = x;
            Y = y;
        }
    }

    /// <summary>What a Thing is.</summary>
    public enum ThingKind
    {
        Person,
        Object,
        Sound
    }

    /// <summary>Something in the scene beside the figure; its id names it as long as the engine lives.</summary>
    public sealed class Thing
    {
        public readonly string Id;
        public readonly ThingKind Kind;
        public readonly string Name;
        public readonly double X;
        public readonly double Y;
        public readonly double Th;

        public Thing(string id, ThingKind kind, string name, double x, double y, double th)
        {
            Id = id;
            Kind = kind;
            Name = name;
            X = x;
            Y = y;
            Th = th;
        }
    }

    /// <summary>Events as they are sent: a LinkException says what does not fit the link.</summary>
    internal static class EventMessage
    {
        private const int MaxObstacles = 100;
        private const int MaxCorners = 1000;
        private const int MaxThings = 100;

        internal static byte[] Completed(string id, Status status)
        {
            return Message("completed", new JProperty("id", Id(id)),
                new JProperty("status", status.ToString().ToUpperInvariant()));
        }

        internal static byte[] Log(string text)
        {
            return Message("log", new JProperty("text", Cut(text ?? "")));
        }

        internal static byte[] Pause(bool on)
        {
            return Message("pause", new JProperty("on", on));
        }

        internal static byte[] Idle()
        {
            return Message("idle");
        }

        internal static byte[] Reached(string id, int index)
        {
            if (index < 0 || index >= Command.MaxPath)
            {
                throw new LinkException("index: there is no such point of a path");
            }
            return Message("reached", new JProperty("id", Id(id)), new JProperty("index", index));
        }

        internal static byte[] Place(double x, double y, double th)
        {
            return Message("place", new JProperty("x", Metres(x)), new JProperty("y", Metres(y)),
                new JProperty("th", Angle(th)));
        }

        internal static byte[] Floor(IList<FloorPoint> outline, IList<IList<FloorPoint>> obstacles)
        {
            int corners = outline.Count;
            JArray inside = new JArray();
            foreach (IList<FloorPoint> obstacle in obstacles)
            {
                corners += obstacle.Count;
                inside.Add(Polygon(obstacle));
            }
            if (obstacles.Count > MaxObstacles || corners > MaxCorners)
            {
                throw new LinkException($"a floor has at most {MaxObstacles} obstacles and {MaxCorners} corners");
            }
            return Message("floor", new JProperty("outline", Polygon(outline)), new JProperty("obstacles", inside));
        }

        internal static byte[] Things(IList<Thing> things)
        {
            HashSet<string> ids = new HashSet<string>();
            JArray all = new JArray();
            foreach (Thing thing in things)
            {
                if (!ids.Add(Id(thing.Id)))
                {
                    throw new LinkException($"things: two have the id '{thing.Id}'");
                }
                all.Add(new JObject(
                    new JProperty("id", thing.Id),
                    new JProperty("kind", thing.Kind.ToString().ToLowerInvariant()),
                    new JProperty("name", Name(thing.Name ?? "", "name")),
                    new JProperty("x", Metres(thing.X)),
                    new JProperty("y", Metres(thing.Y)),
                    new JProperty("th", Angle(thing.Th))));
            }
            if (things.Count > MaxThings)
            {
                throw new LinkException($"things: more than {MaxThings}");
            }
            return Message("things", new JProperty("things", all));
        }

        internal static string Cut(string text)
        {
            if (text.Length <= Member.MaxText)
            {
                return text;
            }
            bool between = char.IsSurrogatePair(text, Member.MaxText - 1);
            return text.Substring(0, between ? Member.MaxText - 1 : Member.MaxText);
        }

        private static byte[] Message(string name, params JProperty[] members)
        {
            return Wire.Json(MessageType.Event, new JObject(new JProperty("event", name), members));
        }

        private static string Id(string id)
        {
            return Name(id, "id");
        }

        private static string Name(string text, string name)
        {
            return Member.Text(new JValue(text), name, Member.MaxName);
        }

        private static double Metres(double value)
        {
            return Math.Round(Member.Real(new JValue(value), "place", -Command.Far, Command.Far), 4);
        }

        private static double Angle(double th)
        {
            return Math.Round(Member.Real(new JValue(Coordinates.Wrapped(th)), "th", -4, 4), 5);
        }

        private static JArray Polygon(IList<FloorPoint> corners)
        {
            if (corners.Count < 3)
            {
                throw new LinkException("floor: expected at least three corners");
            }
            JArray polygon = new JArray();
            foreach (FloorPoint corner in corners)
            {
                polygon.Add(new JArray(Metres(corner.X), Metres(corner.Y)));
            }
            return polygon;
        }
    }
}
