// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>One subscription, whichever its id is at the moment.</summary>
    internal sealed class SubscriptionEntry
    {
        internal readonly string EventType;
        internal readonly string Condition;
        internal readonly Action<EventNotification> Deliver;
        internal readonly Action<Exception> End;

        /// <summary>Events that came by the old id while it was made again, and may come by the new one too.</summary>
        internal readonly HashSet<string> Overlap = new HashSet<string>();

        internal SubscriptionEntry(
            string eventType, string condition, Action<EventNotification> deliver, Action<Exception> end)
        {
            EventType = eventType;
            Condition = condition;
            Deliver = deliver;
            End = end;
        }

        /// <summary>Null while the gateway does not know of it.</summary>
        internal string SubscribeId { get; set; }

        /// <summary>Whether the application was told that it could not be made again.</summary>
        internal bool Missed { get; set; }

        /// <summary>How often it ended without being asked to.</summary>
        internal int Interruptions { get; set; }

        /// <summary>Whether it is being made again beside the old one.</summary>
        internal bool Renewing { get; set; }
    }

    /// <summary>
    /// The subscriptions of one client. A lost engine takes its subscriptions with it, and the only sign of that is that the
    /// profile has changed; so they are made again then, all of them where the gateway does not say which engines have
    /// changed. The id of a subscription begins with that of its engine. The old id counts until the new one is there: no
    /// event is lost, and none comes twice. All of it runs in the client's strand.
    /// </summary>
    internal sealed class Subscriptions
    {
        private const int MostOverlap = 1024;

        private readonly HashSet<SubscriptionEntry> _entries = new HashSet<SubscriptionEntry>();
        private readonly Dictionary<string, SubscriptionEntry> _byId = new Dictionary<string, SubscriptionEntry>();
        private readonly Connection _connection;
        private readonly Action<SubscriptionChange> _tell;

        internal Subscriptions(Connection connection, Action<SubscriptionChange> tell)
        {
            _connection = connection;
            _tell = tell;
        }

        /// <summary>Whether the gateway lacks one that is wanted.</summary>
        internal bool Incomplete
        {
            get { return _entries.Any(entry => entry.SubscribeId == null); }
        }

        /// <exception cref="RoISException">no component has this event, or several do</exception>
        internal Task OpenAsync(SubscriptionEntry entry, CancellationToken token)
        {
            return _connection.AskAsync(
                Methods.EventSubscribe,
                ParamsOf(entry),
                token,
                result =>
                {
                    _entries.Add(entry);
                    Route(entry, result.SubscribeId);
                },
                EndLate);
        }

        /// <summary>Unsubscribes, on this connection if there is one.</summary>
        internal void Close(SubscriptionEntry entry)
        {
            _entries.Remove(entry);
            if (entry.SubscribeId != null)
            {
                _byId.Remove(entry.SubscribeId);
                _connection.Post(
                    Methods.EventUnsubscribe, new UnsubscribeParams { SubscribeId = entry.SubscribeId });
                entry.SubscribeId = null;
            }
        }

        internal void Deliver(EventNotification told)
        {
            SubscriptionEntry entry;
            if (!_byId.TryGetValue(told.SubscribeId, out entry))
            {
                return;
            }
            if (entry.Renewing)
            {
                if (entry.Overlap.Count < MostOverlap)
                {
                    entry.Overlap.Add(told.EventId);
                }
            }
            else if (entry.Overlap.Remove(told.EventId))
            {
                return;
            }
            entry.Deliver(told);
        }

        /// <summary>Notes that the connection has ended, and with it every subscription.</summary>
        internal void ConnectionEnded()
        {
            _byId.Clear();
            foreach (SubscriptionEntry entry in _entries)
            {
                Interrupt(entry);
            }
        }

        /// <summary>Ends all: the client is closed, or gave up with an error.</summary>
        internal void End(Exception error)
        {
            List<SubscriptionEntry> all = _entries.ToList();
            _entries.Clear();
            _byId.Clear();
            foreach (SubscriptionEntry entry in all)
            {
                entry.End(error);
            }
        }

        /// <summary>
        /// Subscribes again to what the gateway does not know of, or engines that have changed may have forgotten.
        /// </summary>
        /// <exception cref="ConnectionLostException">the connection ended</exception>
        internal Task RenewAsync(JsonRpcSession session, long within, ProfileChange change, CancellationToken token)
        {
            return Task.WhenAll(_entries
                .Where(entry => entry.SubscribeId == null || (change != null && change.MayConcern(entry.SubscribeId)))
                .ToList().Select(entry => RenewAsync(session, within, entry, token)));
        }

        private async Task RenewAsync(
            JsonRpcSession session, long within, SubscriptionEntry entry, CancellationToken token)
        {
            string old = entry.SubscribeId;
            entry.Overlap.Clear();
            entry.Renewing = old != null;
            try
            {
                await RpcCall.AskAsync(
                    session, Methods.EventSubscribe, ParamsOf(entry), within, token, told => Renewed(entry, told), EndLate);
            }
            catch (Exception error) when (error is RoISException || error is RpcException || error is TimeoutException)
            {
                Miss(entry, error);
                return;
            }
            if (old != null)
            {
                session.Post(
                    Methods.EventUnsubscribe.Name, RoISJson.ToObject(new UnsubscribeParams { SubscribeId = old }));
            }
            if (entry.Missed || old == null)
            {
                entry.Missed = false;
                _tell(new SubscriptionChange(entry.EventType, entry.Condition, null));
            }
        }

        private void Renewed(SubscriptionEntry entry, SubscribeResult result)
        {
            entry.Renewing = false;
            if (_entries.Contains(entry))
            {
                Route(entry, result.SubscribeId);
            }
            else
            {
                EndLate(result);
            }
        }

        private void Route(SubscriptionEntry entry, string subscribeId)
        {
            if (entry.SubscribeId != null)
            {
                _byId.Remove(entry.SubscribeId);
            }
            entry.SubscribeId = subscribeId;
            _byId[subscribeId] = entry;
        }

        private void Miss(SubscriptionEntry entry, Exception error)
        {
            if (entry.SubscribeId != null)
            {
                _byId.Remove(entry.SubscribeId);
            }
            Interrupt(entry);
            if (!entry.Missed && _entries.Contains(entry))
            {
                entry.Missed = true;
                _tell(new SubscriptionChange(entry.EventType, entry.Condition, error));
            }
        }

        private void EndLate(SubscribeResult result)
        {
            _connection.Post(Methods.EventUnsubscribe, new UnsubscribeParams { SubscribeId = result.SubscribeId });
        }

        private static void Interrupt(SubscriptionEntry entry)
        {
            entry.Renewing = false;
            if (entry.SubscribeId != null)
            {
                entry.Interruptions++;
            }
            entry.SubscribeId = null;
        }

        private static SubscribeParams ParamsOf(SubscriptionEntry entry)
        {
            return new SubscribeParams { EventType = entry.EventType, Condition = entry.Condition };
        }
    }
}
