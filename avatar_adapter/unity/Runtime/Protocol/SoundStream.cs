using System;

namespace OpenRoIS.Link
{
    /// <summary>
    /// Makes blocks for the link out of the sound of a game: 48 kHz, s16, 20 ms each, stamped by counting samples from
    /// the first on. For one thread, such as the one that mixes the game's sound.
    /// </summary>
    public sealed class SoundStream
    {
        /// <summary>Samples of a second.</summary>
        public const int Rate = 48000;

        private const int BlockFrames = 960;

        /// <summary>
        /// Seconds by which the count may be off the clock before it begins anew: a game stood still.
        /// </summary>
        private const double Lost = 0.1;

        private readonly Action<byte[], int, long> _send;
        private readonly int _channels;
        private readonly byte[] _block;
        private readonly float[] _before;
        private int _filled;
        private long _frames;
        private long _startNs;
        private double _position;
        private int _rate;
        private bool _began;

        /// <param name="channels">1 or 2: those of HELLO.</param>
        /// <param name="send">Gets each block, its bytes, and the moment of its first sample.</param>
        public SoundStream(int channels, Action<byte[], int, long> send)
        {
            _channels = channels;
            _send = send;
            _block = new byte[2 * channels * BlockFrames];
            _before = new float[channels];
        }

        /// <summary>Take what was mixed, at the moment at which it was.</summary>
        /// <param name="samples">From -1 to 1, channels in turn.</param>
        /// <param name="channels">Of these samples: mono is sent in both, of more than two the first two are.</param>
        /// <param name="rate">Samples of a second; other than 48,000 they are interpolated, along straight lines.</param>
        /// <param name="nowNs">As of LinkClient.Now.</param>
        public void Take(float[] samples, int channels, int rate, long nowNs)
        {
            int frames = samples.Length / channels;
            long expected = _startNs + Nanoseconds(_frames + _filled);
            if (!_began || rate != _rate || Math.Abs(nowNs - expected) > Lost * 1e9)
            {
                Begin(rate, nowNs);
            }
            double step = (double)rate / Rate;
            // Position 0 is the last frame of the call before, 1 the first of this one.
            for (; _position < frames; _position += step)
            {
                int index = (int)_position;
                float part = (float)(_position - index);
                for (int channel = 0; channel < _channels; channel++)
                {
                    float from = index == 0 ? _before[channel] : Sample(samples, channels, index - 1, channel);
                    float to = part == 0 ? from : Sample(samples, channels, index, channel);
                    Put(from + (to - from) * part, channel);
                }
                Next();
            }
            _position -= frames;
            for (int channel = 0; channel < _channels && frames > 0; channel++)
            {
                _before[channel] = Sample(samples, channels, frames - 1, channel);
            }
        }

        private void Begin(int rate, long nowNs)
        {
            _began = true;
            _rate = rate;
            _startNs = nowNs;
            _frames = 0;
            _filled = 0;
            _position = 1.0;
        }

        /// <summary>Of so many frames; whole numbers, so that the count stays exact.</summary>
        private static long Nanoseconds(long frames)
        {
            return frames * 62500 / 3;
        }

        private float Sample(float[] samples, int channels, int frame, int channel)
        {
            int at = frame * channels;
            if (_channels == 1 && channels > 1)
            {
                return (samples[at] + samples[at + 1]) / 2;
            }
            return samples[at + Math.Min(channel, channels - 1)];
        }

        private void Put(float value, int channel)
        {
            // Not a number is silence.
            float clipped = value >= -1 && value <= 1 ? value : value > 1 ? 1 : value < -1 ? -1 : 0;
            short sample = (short)Math.Round(clipped * 32767);
            int at = 2 * (_filled * _channels + channel);
            _block[at] = (byte)sample;
            _block[at + 1] = (byte)(sample >> 8);
        }

        private void Next()
        {
            if (++_filled == BlockFrames)
            {
                _send(_block, _block.Length, _startNs + Nanoseconds(_frames));
                _frames += BlockFrames;
                _filled = 0;
            }
        }
    }
}
