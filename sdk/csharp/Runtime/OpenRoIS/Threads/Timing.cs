// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>A clock that rings.</summary>
    public interface ITiming
    {
        /// <summary>Milliseconds that only grow.</summary>
        long Milliseconds { get; }

        /// <summary>Calls <c>ring</c> once, on any thread; disposing of what comes back prevents it.</summary>
        IDisposable After(long milliseconds, Action ring);
    }

    /// <summary>The machine's clock, which rings on threads of the pool.</summary>
    public sealed class SystemTiming : ITiming
    {
        public static readonly SystemTiming Instance = new SystemTiming();

        private readonly Stopwatch _watch = Stopwatch.StartNew();

        public long Milliseconds
        {
            get { return _watch.ElapsedMilliseconds; }
        }

        public IDisposable After(long milliseconds, Action ring)
        {
            return new Timer(_ => ring(), null, milliseconds, Timeout.Infinite);
        }
    }

    /// <summary>
    /// A clock that rings when it is pumped: for WebGL, where there are no threads. Its time is its owner's.
    /// </summary>
    public sealed class PumpedTiming : ITiming
    {
        private readonly List<Alarm> _alarms = new List<Alarm>();
        private readonly Func<long> _now;

        /// <param name="now">milliseconds that only grow</param>
        public PumpedTiming(Func<long> now)
        {
            _now = now;
        }

        public long Milliseconds
        {
            get { return _now(); }
        }

        public IDisposable After(long milliseconds, Action ring)
        {
            var alarm = new Alarm(this, _now() + milliseconds, ring);
            lock (_alarms)
            {
                _alarms.Add(alarm);
            }
            return alarm;
        }

        /// <summary>Rings what is due, the earliest first.</summary>
        public void Pump()
        {
            List<Alarm> due;
            lock (_alarms)
            {
                long now = _now();
                due = _alarms.FindAll(alarm => alarm.At <= now);
                _alarms.RemoveAll(alarm => alarm.At <= now);
            }
            due.Sort((one, other) => one.At.CompareTo(other.At));
            foreach (Alarm alarm in due)
            {
                alarm.Ring();
            }
        }

        private sealed class Alarm : IDisposable
        {
            internal readonly long At;
            internal readonly Action Ring;
            private readonly PumpedTiming _timing;

            internal Alarm(PumpedTiming timing, long at, Action ring)
            {
                _timing = timing;
                At = at;
                Ring = ring;
            }

            public void Dispose()
            {
                lock (_timing._alarms)
                {
                    _timing._alarms.Remove(this);
                }
            }
        }
    }

    internal static class Waits
    {
        /// <summary>Waits for some time, or less: a token ends it with <see cref="OperationCanceledException"/>.</summary>
        internal static async Task DelayAsync(this ITiming timing, long milliseconds, CancellationToken token)
        {
            token.ThrowIfCancellationRequested();
            var done = new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);
            using (timing.After(milliseconds, () => done.TrySetResult(true)))
            using (token.Register(() => done.TrySetCanceled()))
            {
                await done.Task;
            }
        }

        /// <summary>Cancels, also in the moment in which the source is disposed of: a clock rings on any thread.</summary>
        internal static void CancelIfThere(this CancellationTokenSource source)
        {
            try
            {
                source.Cancel();
            }
            catch (ObjectDisposedException)
            {
                // What it would have ended is over.
            }
        }

        /// <summary>Lets a task run that nothing waits for; what it throws is of no interest.</summary>
        internal static async void LetRun(this Task task)
        {
            try
            {
                await task;
            }
            catch (Exception)
            {
                // Its author has said so.
            }
        }

        /// <summary>Waits for a task, or until a token ends the wait; the task goes on.</summary>
        internal static async Task<T> OrCanceled<T>(this Task<T> task, CancellationToken token)
        {
            if (!token.CanBeCanceled || task.IsCompleted)
            {
                return await task;
            }
            var canceled = new TaskCompletionSource<T>(TaskCreationOptions.RunContinuationsAsynchronously);
            using (token.Register(() => canceled.TrySetCanceled()))
            {
                return await await Task.WhenAny(task, canceled.Task);
            }
        }
    }
}
