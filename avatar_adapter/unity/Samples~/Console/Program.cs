using System;
using System.Collections.Generic;
using System.Threading;
using OpenRoIS.Link;

namespace OpenRoIS.Samples
{
    /// <summary>
    /// A game engine without Unity: it draws a face that walks over a floor into memory, plays a quiet tone, and obeys
    /// every command of the link. Takes the adapter's address, or finds it in the environment; "socket" as a second
    /// argument lets its pictures go without a ring.
    /// </summary>
    public static class Program
    {
        private const int Width = 320;
        private const int Height = 180;
        private const int PicturesPerSecond = 30;
        private const int AudioRate = 44100;

        public static int Main(string[] arguments)
        {
            string address = arguments.Length > 0 ? arguments[0] : "";
            if (address == "")
            {
                address = Environment.GetEnvironmentVariable("OPENROIS_LINK_ADDRESS") ?? "tcp:127.0.0.1:8766";
            }
            Hello hello = new Hello
            {
                Name = "console",
                Version = "1.0",
                Secret = Environment.GetEnvironmentVariable("OPENROIS_LINK_SECRET"),
                Width = Width,
                Height = Height,
                PicturesPerSecond = PicturesPerSecond,
                AudioChannels = 1,
                Reactions = { "nod", "bow" },
                Hears = true,
                Walks = true,
                TakesInput = true,
                TakesDemand = true,
                Ring = arguments.Length < 2 || arguments[1] != "socket"
            };
            using (LinkClient link = new LinkClient(address, hello))
            {
                link.Start();
                return new Game(link).Play();
            }
        }

        private sealed class Game
        {
            private const double ReactionSeconds = 0.6;

            private readonly LinkClient _link;
            private readonly Walker _walker;
            private readonly Mouth _mouth = new Mouth();
            private readonly SoundStream _sound;
            private readonly Picture _shape = Picture.Bgra(Width, Height, true);
            private readonly byte[] _pixels = new byte[4 * Width * Height];
            private readonly float[] _weights = new float[Visemes.Names.Count];
            private readonly List<Playing> _playing = new List<Playing>();
            private double _lookX;
            private double _lookY;
            private long _mixed;
            private double _unmixed;
            private bool _quits;

            internal Game(LinkClient link)
            {
                _link = link;
                _walker = new Walker(0, 0, -Math.PI / 2, link.Reached, link.Completed);
                _walker.CanStand = (x, y) => Math.Abs(x) < 2.8 && y > -0.8 && y < 3.8;
                _sound = new SoundStream(1, (block, count, at) => link.SendSound(block, count, 1, at));
                link.Floor(
                    new[] { Corner(-3, -1), Corner(3, -1), Corner(3, 4), Corner(-3, 4) }, new IList<FloorPoint>[0]);
            }

            internal int Play()
            {
                long period = 1000000000L / PicturesPerSecond;
                long before = _link.Now;
                while (!_quits)
                {
                    Obey();
                    long now = _link.Now;
                    // More than a second is a clock that was set anew when the adapter came.
                    double seconds = Math.Max(0, Math.Min(1, (now - before) / 1e9));
                    before = now;
                    _walker.Advance(seconds);
                    _link.Place(_walker.X, _walker.Y, _walker.Th);
                    FinishReactions();
                    MakeSound(seconds, now);
                    if (_link.PicturesWanted)
                    {
                        Draw(now);
                        _link.SendPicture(_pixels, _shape, now);
                    }
                    long early = (now + period - _link.Now) / 1000000;
                    if (early > 0)
                    {
                        Thread.Sleep((int)Math.Min(early, period / 1000000));
                    }
                }
                return 0;
            }

            private void Obey()
            {
                Notice notice;
                while (_link.TryTake(out notice))
                {
                    React react = notice as React;
                    Stop stop = notice as Stop;
                    if (react != null)
                    {
                        Begin(react);
                    }
                    else if (stop != null)
                    {
                        EndReactions(each => stop.Id == null || each.Id == stop.Id, Status.Abort);
                    }
                    else
                    {
                        Take(notice);
                    }
                }
            }

            private void Take(Notice notice)
            {
                Look look = notice as Look;
                if (look != null)
                {
                    _lookX = look.X;
                    _lookY = look.Y;
                }
                else if (notice is Speak)
                {
                    _mouth.Take((Speak)notice);
                }
                else if (notice is Silence)
                {
                    _mouth.Silence(_link.Now);
                }
                else if (notice is Heard)
                {
                    _mouth.Take((Heard)notice, _link.Now);
                }
                else if (notice is Walk)
                {
                    _walker.Take((Walk)notice);
                }
                else if (notice is Drive)
                {
                    _walker.Take((Drive)notice);
                }
                else if (notice is Halt)
                {
                    _walker.Halt();
                }
                else if (notice is OperatorInput)
                {
                    Console.WriteLine("input " + ((OperatorInput)notice).Message["event"]);
                }
                else if (notice is Quit)
                {
                    _quits = true;
                }
                else if (!(notice is Demand))
                {
                    TakeConnection(notice);
                }
            }

            private void TakeConnection(Notice notice)
            {
                Disconnected gone = notice as Disconnected;
                NotConnected missing = notice as NotConnected;
                if (gone != null)
                {
                    // What was asked for needs no answer any more.
                    _playing.Clear();
                    _walker.Forget();
                    _mouth.Silence(_link.Now);
                    Console.WriteLine("disconnected: " + gone.Reason);
                }
                else if (missing != null)
                {
                    Console.WriteLine("not connected: " + missing.Reason);
                }
                else
                {
                    Connected connected = (Connected)notice;
                    string way = connected.HasRing ? "with" : "without";
                    Console.WriteLine($"connected to {connected.Adapter} {way} a ring");
                }
            }

            private void Begin(React react)
            {
                if (react.Reaction != "nod" && react.Reaction != "bow")
                {
                    _link.Completed(react.Id, Status.Error);
                    return;
                }
                EndReactions(each => true, Status.Abort);
                _playing.Add(new Playing(react.Id, _link.Now + (long)(ReactionSeconds * 1e9)));
            }

            private void FinishReactions()
            {
                EndReactions(each => each.EndNs <= _link.Now, Status.Ok);
            }

            private void EndReactions(Predicate<Playing> which, Status status)
            {
                foreach (Playing each in _playing.FindAll(which))
                {
                    _link.Completed(each.Id, status);
                }
                _playing.RemoveAll(which);
            }

            private void MakeSound(double seconds, long now)
            {
                _unmixed += seconds * AudioRate;
                int frames = (int)_unmixed;
                _unmixed -= frames;
                float[] samples = new float[2 * frames];
                for (int frame = 0; frame < frames; frame++, _mixed++)
                {
                    samples[2 * frame] = 0.05f * (float)Math.Sin(_mixed * 2 * Math.PI * 440 / AudioRate);
                    samples[2 * frame + 1] = samples[2 * frame];
                }
                _sound.Take(samples, 2, AudioRate, now);
            }

            /// <summary>The bottom row comes first, as in Unity: y grows upwards.</summary>
            private void Draw(long now)
            {
                _mouth.Weigh(now, _weights);
                double open = _weights[Visemes.Open] + 0.5 * (_weights[11] + _weights[13]);
                int size = (int)(40 / (1 + 0.2 * _walker.Y));
                int x = Width / 2 + (int)(_walker.X * 40);
                int y = Height / 2 - (_playing.Count > 0 ? size / 4 : 0);
                Fill(0, 0, Width, Height, 90, 60, 40);
                Fill((int)(now / 10000000 % Width), 0, 8, 8, 255, 255, 255);
                Fill(x - size, y - size, 2 * size, 2 * size, 140, 180, 230);
                for (int side = -1; side <= 1; side += 2)
                {
                    int eye = x + side * size / 2 + (int)(_lookX * size / 6);
                    Fill(eye - 2, y + size / 2 + (int)(_lookY * size / 6), 5, 5, 20, 20, 20);
                }
                int gap = 1 + (int)(open * size / 2);
                Fill(x - size / 3, y - size / 2 - gap / 2, 2 * size / 3, gap, 40, 30, 120);
            }

            private void Fill(int left, int bottom, int width, int height, byte blue, byte green, byte red)
            {
                for (int y = Math.Max(0, bottom); y < Math.Min(Height, bottom + height); y++)
                {
                    for (int x = Math.Max(0, left); x < Math.Min(Width, left + width); x++)
                    {
                        int at = 4 * (y * Width + x);
                        _pixels[at] = blue;
                        _pixels[at + 1] = green;
                        _pixels[at + 2] = red;
                        _pixels[at + 3] = 255;
                    }
                }
            }

            private static FloorPoint Corner(double x, double y)
            {
                return new FloorPoint(x, y);
            }
        }

        private sealed class Playing
        {
            internal readonly string Id;
            internal readonly long EndNs;

            internal Playing(string id, long endNs)
            {
                Id = id;
                EndNs = endNs;
            }
        }
    }
}
