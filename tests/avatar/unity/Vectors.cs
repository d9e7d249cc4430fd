// Does what a file of JSON asks of the package's pure parts, and prints what came of it as JSON. Compiled with the
// package's protocol part, whose internals it uses.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;
using OpenRoIS.Link;

public static class Vectors
{
    public static void Main(string[] arguments)
    {
        JObject asked;
        using (JsonTextReader reader = new JsonTextReader(new StringReader(File.ReadAllText(arguments[0]))))
        {
            reader.DateParseHandling = DateParseHandling.None;
            asked = JObject.Load(reader);
        }
        JObject told = new JObject(
            new JProperty("streams", new JArray(asked["streams"].Select(each => Read((string)each)))),
            new JProperty("mouths", new JArray(asked["mouths"].Select(Speak))),
            new JProperty("places", new JArray(asked["places"].Select(Turn))),
            new JProperty("drives", new JArray(asked["drives"].Select(Drive))),
            new JProperty("sounds", new JArray(asked["sounds"].Select(Sound))),
            new JProperty("refused", new JArray(Refused())));
        Console.WriteLine(told.ToString(Formatting.None));
    }

    /// <summary>
    /// What a connection says after these bytes, which come in pieces: its messages, and what was wrong.
    /// </summary>
    private static JObject Read(string hex)
    {
        byte[] bytes = Bytes(hex);
        FrameReader reader = new FrameReader();
        JArray messages = new JArray();
        string fault = null;
        try
        {
            int piece = 1;
            for (int at = 0; at < bytes.Length;)
            {
                ArraySegment<byte> free = reader.Free;
                int count = Math.Min(Math.Min(piece, free.Count), bytes.Length - at);
                Buffer.BlockCopy(bytes, at, free.Array, free.Offset, count);
                reader.Filled(count);
                at += count;
                piece = piece * 3 + 1;
                object message;
                while (reader.TryTake(out message))
                {
                    messages.Add(Told(message));
                }
            }
        }
        catch (LinkException error)
        {
            fault = error.Message;
        }
        return new JObject(new JProperty("messages", messages), new JProperty("fault", fault));
    }

    private static byte[] Bytes(string hex)
    {
        return Enumerable.Range(0, hex.Length / 2).Select(at => Convert.ToByte(hex.Substring(2 * at, 2), 16)).ToArray();
    }

    private static JObject Told(object message)
    {
        Welcome welcome = message as Welcome;
        Bye bye = message as Bye;
        Heard heard = message as Heard;
        if (welcome != null)
        {
            JObject ring = welcome.RingPath == null ? null : new JObject(
                new JProperty("path", welcome.RingPath),
                new JProperty("slots", welcome.Slots),
                new JProperty("slot_bytes", welcome.SlotBytes));
            JObject told = new JObject(new JProperty("name", welcome.Name), new JProperty("ring", ring));
            if (welcome.NowNs.HasValue)
            {
                told.Add("now_ns", welcome.NowNs.Value);
            }
            return new JObject(new JProperty("welcome", told));
        }
        if (bye != null)
        {
            return new JObject(new JProperty("bye", bye.Reason));
        }
        if (heard != null)
        {
            return new JObject(new JProperty("heard", new JArray(heard.Samples)),
                new JProperty("channels", heard.Channels), new JProperty("timestamp_ns", heard.TimestampNs));
        }
        return new JObject(new JProperty("command", Body((Command)message)));
    }

    private static JObject Body(Command command)
    {
        React react = command as React;
        Stop stop = command as Stop;
        Speak speak = command as Speak;
        Look look = command as Look;
        Walk walk = command as Walk;
        Drive drive = command as Drive;
        OperatorInput input = command as OperatorInput;
        Bitrate bitrate = command as Bitrate;
        JObject body = new JObject(new JProperty("command", command.GetType().Name.ToLowerInvariant()));
        if (react != null)
        {
            body.Add("id", react.Id);
            body.Add("reaction", react.Reaction);
        }
        else if (stop != null)
        {
            body.Add("id", stop.Id);
        }
        else if (speak != null)
        {
            body.Add("id", speak.Id);
            body.Add("start_ns", speak.StartNs);
            body.Add("duration_ms", speak.DurationMs);
            body.Add("visemes", new JArray(speak.Visemes.Select(
                each => new JArray(each.OffsetMs, Visemes.Names[each.Shape], each.Weight))));
        }
        else if (look != null)
        {
            body.Add("x", look.X);
            body.Add("y", look.Y);
        }
        else if (walk != null)
        {
            body.Add("id", walk.Id);
            body.Add("speed", walk.Speed);
            body.Add("path", new JArray(walk.Path.Select(each => new JArray(each.X, each.Y, each.Th))));
        }
        else if (drive != null)
        {
            body.Add("ahead", drive.Ahead);
            body.Add("left", drive.Left);
            body.Add("turn", drive.Turn);
        }
        else if (command is KeyFrame)
        {
            body["command"] = "key_frame";
        }
        else if (bitrate != null)
        {
            body.Add("bits_per_second", bitrate.BitsPerSecond);
        }
        else if (input != null)
        {
            body["command"] = "input";
            body.Add("message", input.Message);
        }
        return body;
    }

    /// <summary>The weights of the visemes at some moments of a Speak, which may be cut.</summary>
    private static JArray Speak(JToken asked)
    {
        Mouth mouth = new Mouth();
        mouth.Take((Speak)Command.Read((JObject)asked["speak"]));
        float[] weights = new float[Visemes.Names.Count];
        JArray all = new JArray();
        long? cut = (long?)asked["cut_ns"];
        foreach (long moment in asked["moments"].Select(each => (long)each))
        {
            if (cut.HasValue && moment >= cut.Value)
            {
                mouth.Silence(cut.Value);
                cut = null;
            }
            mouth.Weigh(moment, weights);
            all.Add(new JArray(weights));
        }
        return all;
    }

    /// <summary>A place and direction in Unity's, and back.</summary>
    private static JArray Turn(JToken place)
    {
        double x;
        double z;
        Coordinates.ToUnity((double)place[0], (double)place[1], out x, out z);
        double yaw = Coordinates.ToYaw((double)place[2]);
        FloorPoint back = Coordinates.ToLink(x, z);
        return new JArray(x, z, yaw, back.X, back.Y, Coordinates.ToTh(yaw));
    }

    /// <summary>Where a figure is after commands and times, and what it has told.</summary>
    private static JObject Drive(JToken steps)
    {
        JArray told = new JArray();
        Walker walker = new Walker(0, 0, -Math.PI / 2,
            (id, index) => told.Add($"reached {id} {index}"),
            (id, status) => told.Add($"completed {id} {status}"));
        walker.CanStand = (x, y) => Math.Abs(x) < 1 && Math.Abs(y) < 1;
        foreach (JToken step in steps)
        {
            Command command = step.Type == JTokenType.Object ? Command.Read((JObject)step) : null;
            if (command is Walk)
            {
                walker.Take((Walk)command);
            }
            else if (command is Drive)
            {
                walker.Take((Drive)command);
            }
            else if (command != null)
            {
                walker.Halt();
            }
            else
            {
                walker.Advance((double)step);
            }
        }
        return new JObject(new JProperty("at", new JArray(walker.X, walker.Y, walker.Th)),
            new JProperty("moving", walker.IsMoving), new JProperty("told", told));
    }

    /// <summary>The blocks that a tone makes.</summary>
    private static JObject Sound(JToken asked)
    {
        int rate = (int)asked["rate"];
        int channels = (int)asked["channels"];
        JArray stamps = new JArray();
        List<short> samples = new List<short>();
        SoundStream stream = new SoundStream((int)asked["to"], (block, count, at) =>
        {
            stamps.Add(at);
            for (int index = 0; index < count; index += 2)
            {
                samples.Add((short)(block[index] | block[index + 1] << 8));
            }
        });
        long frame = 0;
        foreach (JToken call in asked["calls"])
        {
            float[] data = new float[channels * (int)call["frames"]];
            for (int at = 0; at < data.Length; at += channels, frame++)
            {
                for (int channel = 0; channel < channels; channel++)
                {
                    data[at + channel] = (float)(0.5 / (channel + 1) * Math.Sin(2 * Math.PI * 440 * frame / rate));
                }
            }
            stream.Take(data, channels, rate, (long)call["at"]);
        }
        return new JObject(new JProperty("stamps", stamps), new JProperty("samples", new JArray(samples)));
    }

    /// <summary>What is said about what the link does not take.</summary>
    private static IEnumerable<string> Refused()
    {
        LinkClient link = new LinkClient("tcp:127.0.0.1:1", new Hello());
        LinkClient encoding = new LinkClient("tcp:[::1]:1", new Hello { Encodes = true });
        FloorPoint[] corner = { new FloorPoint(0, 0) };
        Thing thing = new Thing("a", ThingKind.Object, null, 0, 0, 0);
        Thing half = new Thing("\ud800", ThingKind.Object, null, 0, 0, 0);
        Thing far = new Thing("a", ThingKind.Object, null, 1e5, 0, 0);
        Action[] all =
        {
            () => new LinkClient("127.0.0.1:1", new Hello()),
            () => new LinkClient("unix:", new Hello()),
            () => link.Place(double.NaN, 0, 0),
            () => link.Floor(corner, new IList<FloorPoint>[0]),
            () => link.Things(new[] { thing, thing }),
            () => link.Things(new[] { half }),
            () => link.Things(new[] { far }),
            () => link.SendPicture(new byte[3], Picture.Bgra(2, 2, false), 0),
            () => new Picture(1, 2, 8, PixelFormat.Bgra, false),
            () => new Picture(3, 2, 4, PixelFormat.I420, false),
            () => new Picture(4, 2, 8, PixelFormat.Bgra, false),
            () => new Picture(16384, 16384, 65536, PixelFormat.Bgra, false),
            () => encoding.SendEncoded(new byte[1], 2, 1, 0, true),
            () => encoding.SendEncoded(new byte[0], 2, 2, 0, true),
            () => link.SendEncoded(new byte[1], 2, 2, 0, true),
            () => encoding.SendPicture(new byte[16], Picture.Bgra(2, 2, false), 0),
            () => link.SendSound(new byte[3], 3, 1, 0)
        };
        foreach (Action each in all)
        {
            string said = "nothing";
            try
            {
                each();
            }
            catch (LinkException error)
            {
                said = error.Message;
            }
            yield return said;
        }
    }
}
