// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Threading;

namespace OpenRoIS
{
    /// <summary>
    /// Hands items to a callback in the application's context. They wait in a bounded feed, and take one place in the
    /// context's own queue together: a thread that does not pump for a while finds the newest of them, not all.
    /// </summary>
    internal sealed class Callbacks<T>
    {
        private readonly Feed<T> _feed;
        private readonly SynchronizationContext _context;
        private readonly Action<T> _callback;
        private readonly Action<Exception> _failed;
        private int _posted;
        private volatile bool _ended;

        internal Callbacks(SynchronizationContext context, Action<T> callback, Action<Exception> failed, int buffer)
        {
            _feed = new Feed<T>(buffer);
            _context = context;
            _callback = callback;
            _failed = failed;
        }

        internal int Dropped
        {
            get { return _feed.Dropped; }
        }

        /// <summary>No callback begins after this was called in the context.</summary>
        internal void End()
        {
            _ended = true;
            _feed.End();
        }

        internal void Offer(T item)
        {
            _feed.Offer(item);
            if (Interlocked.Exchange(ref _posted, 1) == 1)
            {
                return;
            }
            try
            {
                _context.Post(_ => CallBack(), null);
            }
            catch (Exception error)
            {
                // The application's context is over, or has a fault; the client goes on.
                Interlocked.Exchange(ref _posted, 0);
                Failures.Report(_failed, error);
            }
        }

        private void CallBack()
        {
            // First: what is offered from here on posts again.
            Interlocked.Exchange(ref _posted, 0);
            foreach (T item in _feed.TakeAll())
            {
                if (_ended)
                {
                    return;
                }
                try
                {
                    _callback(item);
                }
                catch (Exception error)
                {
                    Failures.Report(_failed, error);
                }
            }
        }
    }
}
