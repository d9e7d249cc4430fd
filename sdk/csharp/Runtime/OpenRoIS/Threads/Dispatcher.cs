// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Threading;

namespace OpenRoIS
{
    /// <summary>
    /// Brings callbacks to one thread: what is posted waits until that thread calls <see cref="Pump"/>, as Unity's does in
    /// each <c>Update</c>. As <see cref="ClientOptions.Callbacks"/> it takes one place for each subscription and one for
    /// the client's notices, however many of them wait: they wait in feeds, which are bounded.
    /// </summary>
    public sealed class Dispatcher : SynchronizationContext
    {
        private readonly Queue<Action> _waiting = new Queue<Action>();
        private readonly Action<Exception> _failed;
        private int _thread;

        /// <param name="failed">takes what a callback has thrown; others still get their turn</param>
        public Dispatcher(Action<Exception> failed)
        {
            if (failed == null)
            {
                throw new ArgumentNullException("failed");
            }
            _failed = failed;
        }

        /// <summary>How much waits for the next <see cref="Pump"/>.</summary>
        public int Waiting
        {
            get
            {
                lock (_waiting)
                {
                    return _waiting.Count;
                }
            }
        }

        public override void Post(SendOrPostCallback work, object state)
        {
            lock (_waiting)
            {
                _waiting.Enqueue(() => work(state));
            }
        }

        /// <exception cref="NotSupportedException">this is not the thread that pumps: post the work</exception>
        public override void Send(SendOrPostCallback work, object state)
        {
            if (Thread.CurrentThread.ManagedThreadId != _thread)
            {
                throw new NotSupportedException("only the thread that pumps runs callbacks: post the work");
            }
            work(state);
        }

        public override SynchronizationContext CreateCopy()
        {
            return this;
        }

        /// <summary>
        /// Runs what waits now, in order, and returns how much that was. What callbacks post meanwhile waits for the next
        /// time: a frame ends.
        /// </summary>
        /// <param name="atMost">callbacks; the rest waits for the next time</param>
        public int Pump(int atMost = 1024)
        {
            _thread = Thread.CurrentThread.ManagedThreadId;
            int due = Math.Min(Waiting, atMost);
            SynchronizationContext former = Current;
            SetSynchronizationContext(this);
            try
            {
                for (int done = 0; done < due; done++)
                {
                    Action work;
                    lock (_waiting)
                    {
                        if (_waiting.Count == 0)
                        {
                            // A callback has pumped, too.
                            return done;
                        }
                        work = _waiting.Dequeue();
                    }
                    Try(work);
                }
            }
            finally
            {
                SetSynchronizationContext(former);
            }
            return due;
        }

        private void Try(Action work)
        {
            try
            {
                work();
            }
            catch (Exception error)
            {
                _failed(error);
            }
        }
    }
}
