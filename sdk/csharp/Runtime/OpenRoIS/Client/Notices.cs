// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Threading;
using Newtonsoft.Json.Linq;

namespace OpenRoIS
{
    /// <summary>The state of a client's connection.</summary>
    public enum ConnectionState
    {
        /// <summary>It is not open yet, or will not be again.</summary>
        Closed,

        /// <summary>An attempt is under way.</summary>
        Connecting,

        Connected,

        /// <summary>It ended; the next attempt comes in a while.</summary>
        Waiting
    }

    /// <summary>The connection is in another state.</summary>
    public sealed class ConnectionChange
    {
        internal ConnectionChange(ConnectionState state, string reason, TimeSpan? retryIn)
        {
            State = state;
            Reason = reason;
            RetryIn = retryIn;
        }

        public ConnectionState State { get; private set; }

        /// <summary>Why it ended, one sentence; empty for a connection.</summary>
        public string Reason { get; private set; }

        /// <summary>The time until the next attempt; null where there is none.</summary>
        public TimeSpan? RetryIn { get; private set; }
    }

    /// <summary>
    /// A component that was bound is not any more: it is gone, or another application has it by now. It is bound again as
    /// soon as it can be, unless it is released, or was handed over or taken.
    /// </summary>
    public sealed class BindingLoss
    {
        internal BindingLoss(string componentRef, Exception error)
        {
            ComponentRef = componentRef;
            Error = error;
        }

        public string ComponentRef { get; private set; }

        /// <summary>Why, as the operation that found out would have thrown it.</summary>
        public Exception Error { get; private set; }
    }

    /// <summary>
    /// An application of higher rank has taken a component that was bound; it comes back. What ran there ends with ABORT,
    /// and commands are refused meanwhile.
    /// </summary>
    public sealed class BindingLoan
    {
        internal BindingLoan(string componentRef, string holder, TimeSpan returnsIn)
        {
            ComponentRef = componentRef;
            Holder = holder;
            ReturnsIn = returnsIn;
        }

        public string ComponentRef { get; private set; }

        /// <summary>The subject of the application that has it.</summary>
        public string Holder { get; private set; }

        /// <summary>The time after which it comes back at the latest, unless it is taken for longer.</summary>
        public TimeSpan ReturnsIn { get; private set; }
    }

    /// <summary>
    /// A body that was reserved is not any more, because a required part of it is lost; the others were released. It is not
    /// reserved again: release it, and reserve another one.
    /// </summary>
    public sealed class BodyLoss
    {
        internal BodyLoss(string engineId, string componentRef, Exception error)
        {
            EngineId = engineId;
            ComponentRef = componentRef;
            Error = error;
        }

        public string EngineId { get; private set; }

        /// <summary>The part that was lost; empty where the client has no connection any more.</summary>
        public string ComponentRef { get; private set; }

        /// <summary>Why, as the operation that found out would have thrown it.</summary>
        public Exception Error { get; private set; }
    }

    /// <summary>A subscription is gone, or is made again; events in between are missing.</summary>
    public sealed class SubscriptionChange
    {
        internal SubscriptionChange(string eventType, string condition, Exception error)
        {
            EventType = eventType;
            Condition = condition;
            Error = error;
        }

        public string EventType { get; private set; }

        public string Condition { get; private set; }

        /// <summary>Why it could not be made again, which is tried further; null where it was.</summary>
        public Exception Error { get; private set; }
    }

    /// <summary>A notification as it came, also one of an extension.</summary>
    public sealed class NotificationMessage
    {
        internal NotificationMessage(string method, JObject given)
        {
            Method = method;
            Params = given;
        }

        /// <summary>Such as <c>signaling.offer</c>.</summary>
        public string Method { get; private set; }

        public JObject Params { get; private set; }
    }

    /// <summary>
    /// What concerns a whole client. All of it comes in the context of <see cref="ClientOptions.Callbacks"/>; of what
    /// waits there the newest 256 are kept.
    /// </summary>
    public abstract class ClientNotices
    {
        private const int Buffer = 256;

        private readonly Callbacks<Action> _callbacks;
        private readonly Dictionary<string, string> _stops = new Dictionary<string, string>();

        internal ClientNotices(SynchronizationContext context, Action<Exception> failed)
        {
            _callbacks = new Callbacks<Action>(context, notice => notice(), failed, Buffer);
        }

        /// <summary>There is a connection (again), or none.</summary>
        public event Action<ConnectionChange> ConnectionChanged;

        /// <summary>The engines or components behind the gateway have changed.</summary>
        public event Action<ProfileChange> ProfileChanged;

        /// <summary>An engine or component reports a fault; <see cref="Operations.GetErrorDetailAsync"/> says more.</summary>
        public event Action<ErrorNotification> Fault;

        public event Action<BodyLoss> BodyLost;

        public event Action<BindingLoss> BindingLost;

        /// <summary>
        /// A component was taken for a time: <see cref="BindingRestored"/> follows, or <see cref="BindingLost"/>.
        /// </summary>
        public event Action<BindingLoan> BindingLent;

        /// <summary>A component, by its reference, is bound again. This connection started none of its commands.</summary>
        public event Action<string> BindingRestored;

        public event Action<SubscriptionChange> SubscriptionLost;

        public event Action<SubscriptionChange> SubscriptionRestored;

        /// <summary>A component has another holder, or another queue.</summary>
        public event Action<LeaseChangedNotification> ControlChanged;

        /// <summary>
        /// Another application requests a component that this one holds: <see cref="Control.GrantAsync"/> or
        /// <see cref="Control.DeclineAsync"/>.
        /// </summary>
        public event Action<LeaseRequestedNotification> ControlRequested;

        /// <summary>The holder keeps a component that this application has requested.</summary>
        public event Action<LeaseDeclinedNotification> ControlDeclined;

        /// <summary>Another application has withdrawn its request: to answer it is too late.</summary>
        public event Action<LeaseWithdrawnNotification> ControlWithdrawn;

        /// <summary>A person has stopped a body, so that programs have to wait; an empty By: it is handed back.</summary>
        public event Action<StoppedNotification> ControlStopped;

        /// <summary>So many events and faults were dropped, because this application reads too slowly.</summary>
        public event Action<long> EventsDropped;

        /// <summary>Every notification as it comes, those of other extensions too.</summary>
        public event Action<NotificationMessage> NotificationReceived;

        /// <summary>Notices that were dropped because the application's context did not run.</summary>
        public int DroppedNotices
        {
            get { return _callbacks.Dropped; }
        }

        internal void Notify(ConnectionChange change)
        {
            _callbacks.Offer(() => ConnectionChanged?.Invoke(change));
        }

        internal void Notify(ProfileChange change)
        {
            _callbacks.Offer(() => ProfileChanged?.Invoke(change));
        }

        internal void Notify(BodyLoss loss)
        {
            _callbacks.Offer(() => BodyLost?.Invoke(loss));
        }

        internal void Notify(BindingLoss loss)
        {
            _callbacks.Offer(() => BindingLost?.Invoke(loss));
        }

        internal void Notify(BindingLoan loan)
        {
            _callbacks.Offer(() => BindingLent?.Invoke(loan));
        }

        internal void NotifyBindingRestored(string componentRef)
        {
            _callbacks.Offer(() => BindingRestored?.Invoke(componentRef));
        }

        internal void Notify(SubscriptionChange change)
        {
            _callbacks.Offer(() => (change.Error == null ? SubscriptionRestored : SubscriptionLost)?.Invoke(change));
        }

        internal void Notify(LeaseChangedNotification changed)
        {
            _callbacks.Offer(() => ControlChanged?.Invoke(changed));
        }

        /// <summary>Tells of a notification that concerns nothing but the application.</summary>
        internal void Notify(string method, JObject given)
        {
            if (NotificationReceived != null)
            {
                _callbacks.Offer(() => NotificationReceived?.Invoke(new NotificationMessage(method, given)));
            }
            if (method == Notifications.SystemNotifyError.Name)
            {
                Offer<ErrorNotification>(given, told => Fault?.Invoke(told));
            }
            else if (method == Notifications.LeaseRequested.Name)
            {
                Offer<LeaseRequestedNotification>(given, told => ControlRequested?.Invoke(told));
            }
            else if (method == Notifications.LeaseDeclined.Name)
            {
                Offer<LeaseDeclinedNotification>(given, told => ControlDeclined?.Invoke(told));
            }
            else if (method == Notifications.LeaseWithdrawn.Name)
            {
                Offer<LeaseWithdrawnNotification>(given, told => ControlWithdrawn?.Invoke(told));
            }
            else if (method == Notifications.LeaseStopped.Name)
            {
                StoppedNotification stopped = RpcCall.ReadNotification<StoppedNotification>(given);
                if (stopped != null)
                {
                    NoteStop(stopped.EngineId, stopped.By == "" ? "" : stopped.StopId);
                    _callbacks.Offer(() => ControlStopped?.Invoke(stopped));
                }
            }
            else if (method == Notifications.EventsDropped.Name)
            {
                Offer<EventsDroppedNotification>(given, told => EventsDropped?.Invoke(told.Count));
            }
        }

        /// <summary>Notes which STOP of an engine holds, so that a hand-back names it; empty for none.</summary>
        internal void NoteStop(string engineId, string stopId)
        {
            _stops.Remove(engineId);
            if (!string.IsNullOrEmpty(stopId))
            {
                _stops[engineId] = stopId;
            }
        }

        /// <summary>Returns the STOP that is to end, and forgets it; null where none was told.</summary>
        internal string TakeStop(string engineId)
        {
            string stopId;
            _stops.TryGetValue(engineId, out stopId);
            _stops.Remove(engineId);
            return stopId;
        }

        private void Offer<T>(JObject given, Action<T> tell)
            where T : class
        {
            T told = RpcCall.ReadNotification<T>(given);
            if (told != null)
            {
                _callbacks.Offer(() => tell(told));
            }
        }
    }
}
