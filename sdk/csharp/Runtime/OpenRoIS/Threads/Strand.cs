// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// Runs what is posted to it one after another, so that what a client knows needs no locks: awaits in it come back
    /// to it. It borrows threads of the pool, or runs in turns of another context: where there are no threads (WebGL)
    /// that is a <see cref="Dispatcher"/>.
    /// </summary>
    public sealed class Strand : SynchronizationContext
    {
        /// <summary>Pieces of work in one turn, before others get theirs.</summary>
        private const int MostInOneTurn = 64;

        private readonly Queue<Action> _waiting = new Queue<Action>();
        private readonly SynchronizationContext _below;
        private readonly Action<Exception> _failed;
        private bool _running;

        /// <param name="below">runs the turns; null for the thread pool</param>
        /// <param name="failed">takes what work has thrown that nothing awaits; such work is a mistake in its author</param>
        public Strand(SynchronizationContext below = null, Action<Exception> failed = null)
        {
            _below = below;
            _failed = failed ?? (_ => { });
        }

        public override void Post(SendOrPostCallback work, object state)
        {
            Post(() => work(state));
        }

        /// <summary>Runs some work in its turn, from any thread.</summary>
        public void Post(Action work)
        {
            lock (_waiting)
            {
                _waiting.Enqueue(work);
                if (_running)
                {
                    return;
                }
                _running = true;
            }
            Schedule();
        }

        /// <exception cref="NotSupportedException">always: to wait for a turn here could last for ever</exception>
        public override void Send(SendOrPostCallback work, object state)
        {
            throw new NotSupportedException("post the work, and await its task");
        }

        public override SynchronizationContext CreateCopy()
        {
            return this;
        }

        /// <summary>Runs asynchronous work here; its outcome is the caller's, in the caller's own context.</summary>
        public Task<T> Run<T>(Func<Task<T>> work)
        {
            // Else the rest of the caller's method would run in this strand, and could hold it up.
            var done = new TaskCompletionSource<T>(TaskCreationOptions.RunContinuationsAsynchronously);
            Post(() => Settle(work, done));
            return done.Task;
        }

        /// <summary>Runs asynchronous work here; its end is the caller's, in the caller's own context.</summary>
        public Task Run(Func<Task> work)
        {
            return Run(async () =>
            {
                await work();
                return true;
            });
        }

        private static async void Settle<T>(Func<Task<T>> work, TaskCompletionSource<T> done)
        {
            try
            {
                done.TrySetResult(await work());
            }
            catch (OperationCanceledException)
            {
                done.TrySetCanceled();
            }
            catch (Exception error)
            {
                done.TrySetException(error);
            }
        }

        private void Schedule()
        {
            if (_below == null)
            {
                ThreadPool.QueueUserWorkItem(_ => TakeTurn());
            }
            else
            {
                _below.Post(_ => TakeTurn(), null);
            }
        }

        private void TakeTurn()
        {
            SynchronizationContext former = Current;
            SetSynchronizationContext(this);
            try
            {
                for (int done = 0; done < MostInOneTurn; done++)
                {
                    Action work;
                    lock (_waiting)
                    {
                        if (_waiting.Count == 0)
                        {
                            _running = false;
                            return;
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
            Schedule();
        }

        private void Try(Action work)
        {
            try
            {
                work();
            }
            catch (Exception error) when (!(error is ThreadAbortException))
            {
                // A thread is aborted where its domain ends: with the process, or as Unity loads scripts anew.
                Failures.Report(_failed, error);
            }
        }
    }
}
