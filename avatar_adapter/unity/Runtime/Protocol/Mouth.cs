using System;
using System.Collections.Generic;

namespace OpenRoIS.Link
{
    /// <summary>
    /// What the mouth does while the avatar speaks, or the operator through it: the weight of each of the Visemes at
    /// any moment. Shapes flow into each other as lips do; closed lips are a little early. Of one thread.
    /// </summary>
    public sealed class Mouth
    {
        /// <summary>Seconds over which one shape turns into the next.</summary>
        private const double Spread = 0.11;

        /// <summary>Seconds by which lips are ahead of the sound.</summary>
        private const double Early = 0.02;

        /// <summary>Seconds in which a mouth that is told to be silent closes.</summary>
        private const double Cut = 0.08;

        /// <summary>The level, 1 being full scale, at which the operator's voice opens the mouth wholly.</summary>
        private const double Loud = 0.12;

        /// <summary>Seconds in which it closes after the operator.</summary>
        private const double Fade = 0.12;
        private const int MaxPending = 64;

        private readonly List<Track> _tracks = new List<Track>();
        private double _level;
        private long _heardAt;

        /// <summary>A Speak has come; of very many that are pending the oldest are forgotten.</summary>
        public void Take(Speak speak)
        {
            if (_tracks.Count >= MaxPending)
            {
                _tracks.RemoveAt(0);
            }
            _tracks.Add(new Track(speak));
        }

        /// <summary>A Silence has come, or the adapter is gone.</summary>
        public void Silence(long nowNs)
        {
            foreach (Track track in _tracks)
            {
                track.CutAt(nowNs);
            }
        }

        /// <summary>
        /// The operator's voice: where the avatar does not speak itself, the mouth opens with its loudness.
        /// </summary>
        public void Take(Heard heard, long nowNs)
        {
            int loudest = 0;
            foreach (short sample in heard.Samples)
            {
                loudest = Math.Max(loudest, Math.Abs((int)sample));
            }
            _level = Math.Min(1.0, loudest / 32768.0 / Loud);
            _heardAt = nowNs;
        }

        /// <summary>Write the weight of each of the Visemes, from 0 to 1; all are 0 in a mouth at rest.</summary>
        public void Weigh(long nowNs, float[] weights)
        {
            Array.Clear(weights, 0, weights.Length);
            bool speaks = false;
            for (int index = _tracks.Count - 1; index >= 0; index--)
            {
                if (_tracks[index].IsOver(nowNs))
                {
                    _tracks.RemoveAt(index);
                }
                else
                {
                    speaks |= _tracks[index].AddTo(weights, nowNs);
                }
            }
            if (!speaks)
            {
                weights[Visemes.Open] = (float)(_level * Math.Max(0.0, 1.0 - Seconds(nowNs - _heardAt) / Fade));
            }
        }

        private static double Seconds(long ns)
        {
            return ns / 1e9;
        }

        /// <summary>A step from 0 to 1 over 0..1 that starts and ends without speed.</summary>
        private static double Smooth(double value)
        {
            double clipped = Math.Min(Math.Max(value, 0.0), 1.0);
            return clipped * clipped * (3.0 - 2.0 * clipped);
        }

        private sealed class Track
        {
            private readonly Speak _speak;
            private long? _cut;

            internal Track(Speak speak)
            {
                _speak = speak;
            }

            internal void CutAt(long nowNs)
            {
                _cut = _cut ?? nowNs;
            }

            internal bool IsOver(long nowNs)
            {
                double rest = _cut.HasValue
                    ? Seconds(nowNs - _cut.Value) - Cut
                    : Seconds(nowNs - _speak.StartNs) - _speak.DurationMs / 1000.0;
                return rest > Spread;
            }

            /// <summary>Add the shapes of this moment; whether there are any.</summary>
            internal bool AddTo(float[] weights, long nowNs)
            {
                double at = Seconds(nowNs - _speak.StartNs) + Early;
                double loudness = _cut.HasValue ? 1.0 - Smooth(Seconds(nowNs - _cut.Value) / Cut) : 1.0;
                double duration = _speak.DurationMs / 1000.0;
                double present = 0.0;
                for (int index = FirstAt(at); index < _speak.Visemes.Count; index++)
                {
                    Viseme viseme = _speak.Visemes[index];
                    double begin = viseme.OffsetMs / 1000.0;
                    if (begin - Spread / 2 > at || begin >= duration)
                    {
                        break;
                    }
                    double end = Math.Min(EndOf(index), duration);
                    double amount = (Risen(at - begin) - Risen(at - end)) * loudness;
                    present += amount;
                    weights[viseme.Shape] = (float)Math.Min(1.0, weights[viseme.Shape] + amount * viseme.Weight);
                }
                return present > 0.0;
            }

            /// <summary>The first viseme that is not over yet.</summary>
            private int FirstAt(double at)
            {
                int low = 0;
                int high = _speak.Visemes.Count;
                while (low < high)
                {
                    int middle = (low + high) / 2;
                    if (EndOf(middle) + Spread / 2 < at)
                    {
                        low = middle + 1;
                    }
                    else
                    {
                        high = middle;
                    }
                }
                return low;
            }

            private double EndOf(int index)
            {
                bool last = index + 1 >= _speak.Visemes.Count;
                return last ? _speak.DurationMs / 1000.0 : _speak.Visemes[index + 1].OffsetMs / 1000.0;
            }

            private static double Risen(double since)
            {
                return Smooth(since / Spread + 0.5);
            }
        }
    }
}
