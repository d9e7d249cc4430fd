using System;
using System.Collections.Generic;
using System.Threading;

namespace OpenRoIS.Link
{
    /// <summary>
    /// What has come and was not taken yet. Of the operator's sound the newest blocks are kept; when too much else
    /// waits, the connection is not read until some was taken, and the adapter cuts it when it has had enough of that.
    /// </summary>
    internal sealed class Inbox
    {
        internal const int MaxHeard = 25;
        internal const int MaxNotices = 1024;

        private readonly object _changed = new object();
        private readonly LinkedList<Notice> _notices = new LinkedList<Notice>();
        private readonly Queue<Heard> _heard = new Queue<Heard>();
        private bool _closed;

        /// <summary>Called by the thread that reads; waits while there is no room.</summary>
        internal void Put(Notice notice)
        {
            lock (_changed)
            {
                // Who has ended it waits for nothing more.
                if (_closed)
                {
                    return;
                }
                Heard heard = notice as Heard;
                if (heard != null)
                {
                    PutHeard(heard);
                    return;
                }
                // Not every attempt is reported.
                if (notice is NotConnected && _notices.Last?.Value is NotConnected)
                {
                    _notices.RemoveLast();
                }
                while (_notices.Count >= MaxNotices && !_closed)
                {
                    Monitor.Wait(_changed);
                }
                _notices.AddLast(notice);
            }
        }

        internal bool TryTake(out Notice notice)
        {
            lock (_changed)
            {
                notice = null;
                if (_notices.Count > 0)
                {
                    notice = _notices.First.Value;
                    _notices.RemoveFirst();
                    Monitor.Pulse(_changed);
                }
                else if (_heard.Count > 0)
                {
                    notice = _heard.Dequeue();
                }
                return notice != null;
            }
        }

        /// <summary>Let no reader wait any more.</summary>
        internal void Close()
        {
            lock (_changed)
            {
                _closed = true;
                Monitor.PulseAll(_changed);
            }
        }

        private void PutHeard(Heard heard)
        {
            if (_heard.Count >= MaxHeard)
            {
                _heard.Dequeue();
            }
            _heard.Enqueue(heard);
        }
    }
}
