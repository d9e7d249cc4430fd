using System;
using System.Collections.Generic;
using Newtonsoft.Json.Linq;

namespace OpenRoIS.Link
{
    /// <summary>Something that the adapter wants done: one of the classes below.</summary>
    public abstract class Command : Notice
    {
        internal const double MaxSpeed = 10.0;
        internal const double Far = 10000.0;
        internal const int MaxPath = 1000;
        private const int MaxVisemes = 2000;
        private const long MaxBitrate = 1000000000;
        private const long MaxConsumers = 1000000;
        private const long Day = 86400000;

        private static readonly Dictionary<string, Func<JObject, Command>> Readers =
            new Dictionary<string, Func<JObject, Command>>
            {
                { "react", body => new React(Id(body), Member.Text(body["reaction"], "reaction", Member.MaxName)) },
                { "stop", body => new Stop(Member.IsNull(body["id"]) ? null : Id(body)) },
                { "speak", ReadSpeak },
                { "silence", body => new Silence() },
                { "look", body => new Look(Real(body, "x", 1.0), Real(body, "y", 1.0)) },
                { "walk", ReadWalk },
                {
                    "drive",
                    body => new Drive(
                        Real(body, "ahead", MaxSpeed), Real(body, "left", MaxSpeed), Real(body, "turn", MaxSpeed))
                },
                { "halt", body => new Halt() },
                { "key_frame", body => new KeyFrame() },
                { "bitrate", body => new Bitrate(
                    (int)Member.Integer(body["bits_per_second"], "bits_per_second", 1, MaxBitrate)) },
                { "input", body => new OperatorInput(Member.Mapping(body["message"], "message")) },
                { "demand", body => new Demand(
                    (int)Member.Integer(body["consumers"], "consumers", 0, MaxConsumers)) },
                { "quit", body => new Quit() }
            };

        internal Command()
        {
        }

        /// <summary>Read the body of COMMAND; members that are not known are ignored.</summary>
        internal static Command Read(JObject body)
        {
            string name = Member.Text(body["command"], "command", Member.MaxName);
            Func<JObject, Command> read;
            if (!Readers.TryGetValue(name, out read))
            {
                throw new LinkException($"command: unknown: '{name}'");
            }
            return read(body);
        }

        private static string Id(JObject body)
        {
            return Member.Text(body["id"], "id", Member.MaxName);
        }

        private static double Real(JObject body, string name, double most)
        {
            return Member.Real(body[name], name, -most, most);
        }

        private static Command ReadSpeak(JObject body)
        {
            List<Viseme> visemes = new List<Viseme>();
            foreach (JToken item in Member.Array(body["visemes"], "visemes", MaxVisemes))
            {
                JArray three = item as JArray;
                if (three == null || three.Count != 3)
                {
                    throw new LinkException("visemes: expected arrays of three: offset_ms, shape, weight");
                }
                double offset = Member.Real(three[0], "visemes offset_ms", 0, Day);
                int shape = Visemes.IndexOf(Member.Text(three[1], "visemes shape", Member.MaxName));
                if (shape < 0)
                {
                    throw new LinkException("visemes: unknown shape");
                }
                if (visemes.Count > 0 && offset < visemes[visemes.Count - 1].OffsetMs)
                {
                    throw new LinkException("visemes: not in order of time");
                }
                visemes.Add(new Viseme(offset, shape, Member.Real(three[2], "visemes weight", 0, 1)));
            }
            long start = Member.Integer(body["start_ns"], "start_ns", 0, long.MaxValue);
            long duration = Member.Integer(body["duration_ms"], "duration_ms", 0, Day);
            return new Speak(Id(body), start, visemes, duration);
        }

        private static Command ReadWalk(JObject body)
        {
            List<Waypoint> path = new List<Waypoint>();
            foreach (JToken item in Member.Array(body["path"], "path", MaxPath))
            {
                JArray three = item as JArray;
                if (three == null || three.Count != 3)
                {
                    throw new LinkException("path: expected arrays of 3");
                }
                double? th = null;
                if (!Member.IsNull(three[2]))
                {
                    th = Member.Real(three[2], "path", -2 * Math.PI, 2 * Math.PI);
                }
                double x = Member.Real(three[0], "path", -Far, Far);
                path.Add(new Waypoint(x, Member.Real(three[1], "path", -Far, Far), th));
            }
            if (path.Count == 0)
            {
                throw new LinkException("path: expected at least one point");
            }
            return new Walk(Id(body), path, Member.Real(body["speed"], "speed", 0.01, MaxSpeed));
        }
    }

    /// <summary>Play a reaction; answer with Completed of this id when it is over.</summary>
    public sealed class React : Command
    {
        public readonly string Id;
        public readonly string Reaction;

        internal React(string id, string reaction)
        {
            Id = id;
            Reaction = reaction;
        }
    }

    /// <summary>
    /// Stop the reaction with this id, or every one if it is null; each is then Completed with Abort.
    /// </summary>
    public sealed class Stop : Command
    {
        public readonly string Id;

        internal Stop(string id)
        {
            Id = id;
        }
    }

    /// <summary>From OffsetMs on the mouth has this shape, an index into Visemes.Names, until the next one.</summary>
    public struct Viseme
    {
        public readonly double OffsetMs;
        public readonly int Shape;
        public readonly double Weight;

        public Viseme(double offsetMs, int shape, double weight)
        {
            OffsetMs = offsetMs;
            Shape = shape;
            Weight = weight;
        }
    }

    /// <summary>Move the mouth to sound that starts at a moment; several may be pending. Mouth does it.</summary>
    public sealed class Speak : Command
    {
        public readonly string Id;

        /// <summary>In the adapter's time, as LinkClient.Now.</summary>
        public readonly long StartNs;
        public readonly IList<Viseme> Visemes;
        public readonly long DurationMs;

        internal Speak(string id, long startNs, IList<Viseme> visemes, long durationMs)
        {
            Id = id;
            StartNs = startNs;
            Visemes = visemes;
            DurationMs = durationMs;
        }
    }

    /// <summary>Close the mouth now, whatever was spoken.</summary>
    public sealed class Silence : Command
    {
        internal Silence()
        {
        }
    }

    /// <summary>Look: X from -1 (the viewer's left) to 1, Y from -1 (down) to 1.</summary>
    public sealed class Look : Command
    {
        public readonly double X;
        public readonly double Y;

        internal Look(double x, double y)
        {
            X = x;
            Y = y;
        }
    }

    /// <summary>A point of a path, and where to look there; null for along the way.</summary>
    public struct Waypoint
    {
        public readonly double X;
        public readonly double Y;
        public readonly double? Th;

        public Waypoint(double x, double y, double? th)
        {
            X = x;
            Y = y;
            Th = th;
        }
    }

    /// <summary>
    /// Go straight to each point in turn; answer with Reached for each, and one Completed. Walker does it.
    /// </summary>
    public sealed class Walk : Command
    {
        public readonly string Id;
        public readonly IList<Waypoint> Path;

        /// <summary>Metres a second.</summary>
        public readonly double Speed;

        internal Walk(string id, IList<Waypoint> path, double speed)
        {
            Id = id;
            Path = path;
            Speed = speed;
        }
    }

    /// <summary>Go with this velocity until the next one, 0.5 s at most; ends a Walk.</summary>
    public sealed class Drive : Command
    {
        /// <summary>Metres a second.</summary>
        public readonly double Ahead;
        public readonly double Left;

        /// <summary>Radians a second, counter-clockwise.</summary>
        public readonly double Turn;

        internal Drive(double ahead, double left, double turn)
        {
            Ahead = ahead;
            Left = left;
            Turn = turn;
        }
    }

    /// <summary>Stand still now.</summary>
    public sealed class Halt : Command
    {
        internal Halt()
        {
        }
    }

    /// <summary>
    /// What the operator does with keyboard, mouse, touch and gamepad: a message of docs/reference/wire.md, "Input".
    /// </summary>
    public sealed class OperatorInput : Command
    {
        public readonly JObject Message;

        internal OperatorInput(JObject message)
        {
            Message = message;
        }
    }

    /// <summary>To an engine that encodes: make the next picture a key frame.</summary>
    public sealed class KeyFrame : Command
    {
        internal KeyFrame()
        {
        }
    }

    /// <summary>To an engine that encodes: aim at so much from now on.</summary>
    public sealed class Bitrate : Command
    {
        public readonly int BitsPerSecond;

        internal Bitrate(int bitsPerSecond)
        {
            BitsPerSecond = bitsPerSecond;
        }
    }

    /// <summary>So many want pictures from now on; with none draw nothing. LinkClient.PicturesWanted follows.</summary>
    public sealed class Demand : Command
    {
        public readonly int Consumers;

        internal Demand(int consumers)
        {
            Consumers = consumers;
        }
    }

    /// <summary>End the engine's process.</summary>
    public sealed class Quit : Command
    {
        internal Quit()
        {
        }
    }
}
