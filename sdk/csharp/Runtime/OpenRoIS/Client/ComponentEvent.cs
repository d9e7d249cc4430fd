// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// An event of one component, to be listened to or read in a loop:
    /// <code>
    /// using (await navigation.ReachedTarget.SubscribeAsync(reached => Show(reached.Target)))
    ///
    /// using (var reached = await navigation.ReachedTarget.ReadAsync())
    /// {
    ///     while (await reached.MoveNextAsync() &amp;&amp; !reached.Current.IsFinalTarget) { }
    /// }
    /// </code>
    /// </summary>
    public sealed class ComponentEvent<T>
    {
        private const int Buffer = 256;

        private readonly Client _client;
        private readonly string _componentRef;
        private readonly Func<Payload, T> _read;

        internal ComponentEvent(Client client, string eventType, string componentRef, Func<Payload, T> read)
        {
            _client = client;
            EventType = eventType;
            _componentRef = componentRef;
            _read = read;
        }

        /// <summary>Its name on the wire.</summary>
        public string EventType { get; private set; }

        /// <summary>
        /// Calls a handler with every event from now on, in the context of <see cref="ClientOptions.Callbacks"/>, until what
        /// comes back is disposed of. It goes on over reconnects, without the events in between.
        /// </summary>
        /// <param name="handler">is called with one event at a time; at most 256 wait, the oldest makes room</param>
        /// <param name="token">ends the wait for the subscription, not the subscription</param>
        /// <exception cref="UnsupportedException">there is no such component</exception>
        public Task<Subscription> SubscribeAsync(Action<T> handler, CancellationToken token = default(CancellationToken))
        {
            if (handler == null)
            {
                throw new ArgumentNullException("handler");
            }
            var callbacks = new Callbacks<T>(_client.CallbackContext, handler, _client.HandlerFailed, Buffer);
            var subscription = new Subscription(
                _client.Application, () => callbacks.Dropped, callbacks.End);
            return Open(subscription, callbacks.Offer, error => { }, token);
        }

        /// <summary>Reads every event from now on in a loop; otherwise as <see cref="SubscribeAsync"/>.</summary>
        public Task<EventReader<T>> ReadAsync(CancellationToken token = default(CancellationToken))
        {
            var feed = new Feed<T>(Buffer);
            return Open(new EventReader<T>(_client.Application, feed), feed.Offer, feed.End, token);
        }

        private Task<TSubscription> Open<TSubscription>(
            TSubscription subscription, Action<T> offer, Action<Exception> end, CancellationToken token)
            where TSubscription : Subscription
        {
            var reading = new EventReading<T>(_client, _read, EventType + " of " + _componentRef, offer);
            var entry = new SubscriptionEntry(EventType, Condition.ComponentRef(_componentRef), reading.TakeEvent, end);
            subscription.Entry = entry;
            subscription.Unreadables = () => reading.Unreadable;
            return _client.Application.Strand.Run(async () =>
            {
                await _client.Application.Subscriptions.OpenAsync(entry, token);
                return subscription;
            });
        }
    }

    /// <summary>A subscription of an application. To dispose of it ends it, also in a handler of its own.</summary>
    public class Subscription : IDisposable
    {
        private readonly Application _application;
        private readonly Func<int> _dropped;
        private readonly Action _end;

        internal Subscription(Application application, Func<int> dropped, Action end)
        {
            _application = application;
            _dropped = dropped;
            _end = end;
        }

        /// <summary>Events that were dropped because the reader was too slow.</summary>
        public int Dropped
        {
            get { return _dropped(); }
        }

        /// <summary>Events that were left out: they do not fit their type, or their details are gone.</summary>
        public int Unreadable
        {
            get { return Unreadables(); }
        }

        /// <summary>How often it ended and had to be made again: events may be missing as often.</summary>
        public int Interruptions
        {
            get { return Entry.Interruptions; }
        }

        /// <summary>Whether the gateway has it now.</summary>
        public bool IsActive
        {
            get { return Entry.SubscribeId != null; }
        }

        internal SubscriptionEntry Entry { get; set; }

        internal Func<int> Unreadables { get; set; }

        public void Dispose()
        {
            _end();
            _application.Strand.Post(() => _application.Subscriptions.Close(Entry));
        }
    }

    /// <summary>A subscription that is read in a loop.</summary>
    public sealed class EventReader<T> : Subscription
    {
        private readonly Feed<T> _feed;

        internal EventReader(Application application, Feed<T> feed)
            : base(application, () => feed.Dropped, () => feed.End())
        {
            _feed = feed;
        }

        /// <summary>The event that <see cref="MoveNextAsync"/> has found.</summary>
        public T Current
        {
            get { return _feed.Current; }
        }

        /// <summary>Waits for the next event; one call at a time.</summary>
        /// <returns>false when there will be no more, because it was disposed of, or the client was closed</returns>
        /// <exception cref="ConnectionLostException">the client gave up for this reason</exception>
        public Task<bool> MoveNextAsync(CancellationToken token = default(CancellationToken))
        {
            return _feed.MoveNextAsync(token);
        }
    }

    /// <summary>
    /// Reads events in the order of their arrival; asks for the details of those that brought none. All of it runs in the
    /// client's strand.
    /// </summary>
    internal sealed class EventReading<T>
    {
        /// <summary>Events that may wait for their details.</summary>
        private const int Most = 256;

        private readonly Queue<EventNotification> _waiting = new Queue<EventNotification>();
        private readonly Client _client;
        private readonly Func<Payload, T> _read;
        private readonly string _what;
        private readonly Action<T> _offer;
        private bool _reading;

        internal EventReading(Client client, Func<Payload, T> read, string what, Action<T> offer)
        {
            _client = client;
            _read = read;
            _what = what;
            _offer = offer;
        }

        internal int Unreadable { get; private set; }

        internal void TakeEvent(EventNotification told)
        {
            if (!_reading && told.Results.Count > 0)
            {
                Offer(told.Results);
                return;
            }
            if (_waiting.Count == Most)
            {
                _waiting.Dequeue();
                Unreadable++;
            }
            _waiting.Enqueue(told);
            if (!_reading)
            {
                ReadWaitingAsync().LetRun();
            }
        }

        private async Task ReadWaitingAsync()
        {
            _reading = true;
            while (_waiting.Count > 0)
            {
                EventNotification told = _waiting.Dequeue();
                IReadOnlyList<Result> results = told.Results;
                if (results.Count == 0)
                {
                    results = await DetailAsync(told.EventId);
                }
                Offer(results);
            }
            _reading = false;
        }

        private async Task<IReadOnlyList<Result>> DetailAsync(string eventId)
        {
            try
            {
                return await _client.GetEventDetailAsync(eventId);
            }
            catch (Exception)
            {
                // It is not known any more, or the connection has ended: without details most events cannot be read.
                return new Result[0];
            }
        }

        private void Offer(IEnumerable<Result> results)
        {
            T payload;
            try
            {
                payload = Payload.Read(_what, results, _read);
            }
            catch (ComponentFailedException)
            {
                Unreadable++;
                return;
            }
            catch (Exception error)
            {
                // A mistake of the author of this component's class.
                Unreadable++;
                _client.HandlerFailed(error);
                return;
            }
            _offer(payload);
        }
    }
}
