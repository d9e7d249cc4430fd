// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// Items that wait for their reader, who calls <see cref="MoveNextAsync"/>. At most so many wait; the oldest makes room
    /// for the newest, and is counted.
    /// </summary>
    public sealed class Feed<T>
    {
        private readonly Queue<T> _items = new Queue<T>();
        private readonly int _buffer;
        private TaskCompletionSource<bool> _news = NewNews();
        private bool _ended;
        private Exception _error;

        internal Feed(int buffer)
        {
            if (buffer < 1)
            {
                throw new ArgumentOutOfRangeException("buffer", "must be at least 1");
            }
            _buffer = buffer;
        }

        /// <summary>Items that were dropped because the reader was too slow.</summary>
        public int Dropped { get; private set; }

        /// <summary>The item that <see cref="MoveNextAsync"/> has found.</summary>
        public T Current { get; private set; }

        /// <summary>
        /// Waits for the next item: <c>while (await feed.MoveNextAsync()) Use(feed.Current);</c>. One call at a time.
        /// </summary>
        /// <returns>false when there will be no more</returns>
        /// <exception cref="ConnectionLostException">the client gave up for this reason</exception>
        public async Task<bool> MoveNextAsync(CancellationToken token = default(CancellationToken))
        {
            while (true)
            {
                Task<bool> news;
                lock (_items)
                {
                    if (_items.Count > 0)
                    {
                        Current = _items.Dequeue();
                        return true;
                    }
                    if (_error != null)
                    {
                        throw _error;
                    }
                    if (_ended)
                    {
                        return false;
                    }
                    news = _news.Task;
                }
                await news.OrCanceled(token);
            }
        }

        internal void Offer(T item)
        {
            lock (_items)
            {
                if (_ended)
                {
                    return;
                }
                if (_items.Count == _buffer)
                {
                    _items.Dequeue();
                    Dropped++;
                }
                _items.Enqueue(item);
            }
            Wake();
        }

        internal void End(Exception error = null)
        {
            lock (_items)
            {
                if (_ended)
                {
                    return;
                }
                _ended = true;
                _error = error;
            }
            Wake();
        }

        /// <summary>Takes everything that waits, at once.</summary>
        internal List<T> TakeAll()
        {
            lock (_items)
            {
                var all = new List<T>(_items);
                _items.Clear();
                return all;
            }
        }

        private void Wake()
        {
            TaskCompletionSource<bool> woken;
            lock (_items)
            {
                woken = _news;
                _news = NewNews();
            }
            woken.TrySetResult(true);
        }

        private static TaskCompletionSource<bool> NewNews()
        {
            return new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);
        }
    }
}
