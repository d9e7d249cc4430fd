using System.Diagnostics;
using System.IO;
using System.Threading;

namespace OpenRoIS.Link
{
    /// <summary>The adapter's clock, CLOCK_MONOTONIC in nanoseconds.</summary>
    internal sealed class MonotonicClock
    {
        /// <summary>
        /// Nanoseconds within which two clocks count as the same one, which both sides have outside of Windows: a
        /// welcome takes no longer on one machine. Who counts from another moment is farther off.
        /// </summary>
        private const long Same = 500000000;

        private long _offset;

        internal long Now
        {
            get { return SystemNs() + Volatile.Read(ref _offset); }
        }

        /// <summary>This machine's clock; on Linux .NET and Mono ask CLOCK_MONOTONIC for it.</summary>
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
            bool same = Path.DirectorySeparatorChar == '/' && offset > -Same && offset < Same;
            Volatile.Write(ref _offset, same ? 0 : offset);
        }
    }
}
