using System.Diagnostics;

namespace OpenRoIS.Link
{
    /// <summary>The adapter's clock, CLOCK_MONOTONIC in nanoseconds.</summary>
    internal sealed class MonotonicClock
    {
        /// <summary>
        /// Nanoseconds within which two clocks count as the same one: a welcome does not travel longer on one machine,
        /// and clocks that are not the same differ by days.
        /// </summary>
        private const long Same = 500000000;

        private long _offset;

        internal long Now
        {
            get { return SystemNs() + System.Threading.Volatile.Read(ref _offset); }
        }

        /// <summary>This machine's clock: CLOCK_MONOTONIC on Linux, where .NET and Mono ask for it.</summary>
        internal static long SystemNs()
        {
            long ticks = Stopwatch.GetTimestamp();
            long second = Stopwatch.Frequency;
            return ticks / second * 1000000000 + (long)(ticks % second * (1e9 / second));
        }

        /// <summary>Set it by what the adapter said the time was.</summary>
        internal void Set(long adapterNs, long receivedNs)
        {
            long offset = adapterNs - receivedNs;
            bool same = offset > -Same && offset < Same;
            System.Threading.Volatile.Write(ref _offset, same ? 0 : offset);
        }
    }
}
