// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// The engines behind the gateway as the client knows them: listed once, in pages, and then only those read that have
    /// changed. For gateways that speak <c>openrois.directory</c>. All of it runs in the client's strand.
    /// </summary>
    internal sealed class EngineDirectory
    {
        internal const string Extension = "openrois.directory";

        private const int MostEngines = 100;

        private readonly Connection _connection;
        private readonly Dictionary<string, EngineEntry> _entries = new Dictionary<string, EngineEntry>();
        private readonly HashSet<string> _stale = new HashSet<string>();
        private readonly SemaphoreSlim _reading = new SemaphoreSlim(1);
        private bool _isListed;

        /// <summary>Counts how often the whole list became invalid.</summary>
        private int _lists;

        internal EngineDirectory(Connection connection)
        {
            _connection = connection;
        }

        /// <summary>Notes that there is another connection, perhaps to another gateway, or that too much has changed.</summary>
        internal void Reset()
        {
            _lists++;
            _isListed = false;
            _entries.Clear();
            _stale.Clear();
        }

        /// <summary>Notes which engines have changed.</summary>
        internal void NoteChanges(DirectoryChangedNotification told)
        {
            if (told.Unnamed > 0)
            {
                Reset();
                return;
            }
            _stale.UnionWith(told.Changed);
            foreach (string engineId in told.Gone)
            {
                _entries.Remove(engineId);
                _stale.Remove(engineId);
            }
        }

        /// <summary>The entries of all engines as they are now; only what has changed is asked for.</summary>
        internal async Task<IReadOnlyList<EngineEntry>> ReadAsync(CancellationToken token)
        {
            await _reading.WaitAsync(token);
            try
            {
                // What has changed and waits to be notified comes before the reply: one reply at least is waited for.
                do
                {
                    await (_isListed ? ReadStaleAsync(token) : ListAsync(token));
                }
                while (!_isListed || _stale.Count > 0);
                return _entries.Values.ToList();
            }
            finally
            {
                _reading.Release();
            }
        }

        private async Task ListAsync(CancellationToken token)
        {
            int lists = _lists;
            string after = "";
            while (true)
            {
                var given = new DirectoryListParams { After = after, Limit = MostEngines };
                DirectoryListResult page = await _connection.AskAsync(
                    Methods.DirectoryList, given, token, told => Keep(lists, told.Engines));
                if (lists != _lists)
                {
                    return;
                }
                if (string.CompareOrdinal(page.Next, after) <= 0)
                {
                    // The last page; one that does not go on would be asked for again and again.
                    _isListed = true;
                    return;
                }
                after = page.Next;
            }
        }

        private Task ReadStaleAsync(CancellationToken token)
        {
            int lists = _lists;
            List<string> some = _stale.Take(MostEngines).ToList();
            return _connection.AskAsync(
                Methods.DirectoryRead,
                new DirectoryReadParams { EngineIds = some },
                token,
                told =>
                {
                    // In the order of the connection: what changes from here on is noted again.
                    if (lists == _lists)
                    {
                        _stale.ExceptWith(some.Except(told.Left));
                    }
                    Keep(lists, told.Engines);
                });
        }

        private void Keep(int lists, IEnumerable<EngineEntry> engines)
        {
            if (lists != _lists)
            {
                return;
            }
            foreach (EngineEntry entry in engines)
            {
                _entries[entry.EngineId] = entry;
            }
        }
    }
}
