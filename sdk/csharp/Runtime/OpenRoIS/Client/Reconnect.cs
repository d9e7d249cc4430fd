// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Text.RegularExpressions;

namespace OpenRoIS
{
    /// <summary>
    /// Waits between attempts: longer each time, and by chance, so that a thousand clients do not come at once.
    /// </summary>
    public sealed class Reconnect
    {
        private static readonly Regex RetryAfter = new Regex(@"^retry_after=([0-9]{1,4}(\.[0-9]{1,6})?)$");

        private readonly Random _chance = new Random();

        /// <summary>The longest first wait.</summary>
        public TimeSpan First { get; set; } = TimeSpan.FromSeconds(0.5);

        /// <summary>By how much each wait is longer than the one before.</summary>
        public double Factor { get; set; } = 1.5;

        /// <summary>The longest wait.</summary>
        public TimeSpan Limit { get; set; } = TimeSpan.FromSeconds(10);

        internal Backoff Begin()
        {
            return new Backoff((long)First.TotalMilliseconds, Factor, (long)Limit.TotalMilliseconds, _chance);
        }

        /// <summary>
        /// The milliseconds that a gateway which is about to restart asks for in the reason of its close, else 0.
        /// </summary>
        internal static long AskedToWait(string reason)
        {
            Match asked = RetryAfter.Match(reason ?? "");
            var culture = System.Globalization.CultureInfo.InvariantCulture;
            return asked.Success ? (long)(1000 * double.Parse(asked.Groups[1].Value, culture)) : 0;
        }
    }

    /// <summary>Waits that grow, of one series of attempts.</summary>
    internal sealed class Backoff
    {
        /// <summary>After an attempt that lasted so many milliseconds the waits begin anew.</summary>
        private const long Lasting = 10000;

        private readonly double _first;
        private readonly double _factor;
        private readonly double _limit;
        private readonly Random _chance;
        private double _next;

        internal Backoff(long first, double factor, long limit, Random chance)
        {
            _first = first;
            _factor = factor;
            _limit = limit;
            _chance = chance;
            _next = first;
        }

        /// <summary>The milliseconds to wait after an attempt that lasted so long: anything up to what has grown.</summary>
        internal long After(long lasted)
        {
            if (lasted >= Lasting)
            {
                _next = _first;
            }
            double wait = _next;
            _next = Math.Min(_next * _factor, _limit);
            lock (_chance)
            {
                return (long)(wait * _chance.NextDouble());
            }
        }
    }
}
