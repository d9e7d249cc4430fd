// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;

namespace OpenRoIS
{
    /// <summary>
    /// What an application has at its gateway, carried from one connection to the next, and the routing of notifications.
    /// All of it runs in the client's strand.
    /// </summary>
    internal sealed class Application : IConnectionOwner
    {
        private const string ExtensionVersion = "1";

        private static readonly string[] Spoken = {
            "rois.stream", "signaling", Resumption.Extension, EngineDirectory.Extension,
        };

        private readonly ClientNotices _notices;
        private readonly ClientOptions _options;
        private readonly Resumption _resumption;
        private readonly Restorer _restorer;
        private CancellationToken _connected;

        internal Application(Uri address, ClientOptions options, Strand strand, ClientNotices notices)
        {
            _notices = notices;
            _options = options;
            Strand = strand;
            Connection = new Connection(address, options, strand, this);
            Commands = new UnfinishedCommands();
            Bindings = new Bindings(BindingLost, notices.NotifyBindingRestored, notices.Notify);
            Subscriptions = new Subscriptions(Connection, notices.Notify);
            Directory = new EngineDirectory(Connection);
            Extensions = new HashSet<string>();
            _resumption = new Resumption(Commands, Bindings, options.Timing, strand);
            _restorer = new Restorer(Bindings, Subscriptions, options);
        }

        internal ClientNotices Notices
        {
            get { return _notices; }
        }

        internal Strand Strand { get; private set; }

        internal Connection Connection { get; private set; }

        internal UnfinishedCommands Commands { get; private set; }

        internal Bindings Bindings { get; private set; }

        internal Subscriptions Subscriptions { get; private set; }

        /// <summary>The engines that there are.</summary>
        internal EngineDirectory Directory { get; private set; }

        /// <summary>What the gateway speaks beyond RoIS.</summary>
        internal HashSet<string> Extensions { get; private set; }

        /// <summary>Counts how often components came or went, as far as that can be known.</summary>
        internal int Generation { get; private set; }

        /// <summary>The milliseconds of the client's clock.</summary>
        internal long TimeNow
        {
            get { return _options.Timing.Milliseconds; }
        }

        /// <summary>Called with each binding that was lost.</summary>
        internal event Action<BindingLoss> OnBindingLost;

        /// <summary>Called with each change of a lease.</summary>
        internal event Action<LeaseChangedNotification> OnLeaseChanged;

        /// <summary>Called with each answer of a holder, and when components came or went: a place in line may be gone.</summary>
        internal event Action<LeaseDeclinedNotification> OnLeaseDoubtful;

        /// <summary>Called when a connection has ended, with the reason, and whether that is for good.</summary>
        internal event Action<string, bool> OnConnectionEnded;

        /// <summary>Called with each notification of signaling and of streams.</summary>
        internal event Action<string, JObject> OnMedia;

        public async Task GreetAsync(JsonRpcSession session, CancellationToken token)
        {
            long within = Connection.RequestTimeout;
            Generation++;
            Directory.Reset();
            await RpcCall.AskAsync(session, Methods.SystemConnect, new NoParams(), within, token);
            Extensions = await HelloAsync(session, within, token);
            await _resumption.GreetAsync(session, within, Extensions.Contains(Resumption.Extension), token);
            await Bindings.RenewAsync(session, within, token);
        }

        public async Task RunBackgroundAsync(JsonRpcSession session, CancellationToken token)
        {
            _connected = token;
            long within = Connection.RequestTimeout;
            Task ends = _resumption.FindEndsAsync(session, within, token);
            Task restoring = _restorer.RunAsync(session, within, token);
            await Task.WhenAll(ends, restoring);
        }

        public void ConnectionEnded(string reason, bool lost, bool again)
        {
            _resumption.ConnectionEnded(reason, lost, again);
            Bindings.ConnectionEnded();
            Subscriptions.ConnectionEnded();
            OnConnectionEnded?.Invoke(reason, !again);
        }

        public void ConnectionChanged(ConnectionState state, string reason, TimeSpan? retryIn)
        {
            _notices.Notify(new ConnectionChange(state, reason, retryIn));
        }

        public void Closed(Exception error)
        {
            Subscriptions.End(error);
        }

        public void HandleNotification(JsonRpcSession session, string method, JObject given)
        {
            if (method == Notifications.CommandCompleted.Name)
            {
                With<Completed>(given, Commands.Completed);
            }
            else if (method == Notifications.EventNotifyEvent.Name)
            {
                With<EventNotification>(given, Subscriptions.Deliver);
            }
            else if (method == Notifications.Reason.Name)
            {
                With<ReasonNotification>(given, told => Explain(session, told));
            }
            else if (method == Notifications.SystemProfileChanged.Name)
            {
                Directory.Reset();
                ProfileChanged(new ProfileChange());
            }
            else if (method == Notifications.DirectoryChanged.Name)
            {
                With<DirectoryChangedNotification>(given, DirectoryChanged);
            }
            else if (method == Notifications.LeaseChanged.Name)
            {
                With<LeaseChangedNotification>(given, LeaseChanged);
            }
            else if (method == Notifications.LeaseDeclined.Name)
            {
                With<LeaseDeclinedNotification>(given, told => OnLeaseDoubtful?.Invoke(told));
            }
            else if (method == Notifications.AuthExpiring.Name && _options.Token != null)
            {
                Tokens.RenewAsync(session, _options, Connection.RequestTimeout, _connected).LetRun();
            }
            else if (method.StartsWith("signaling.") || method.StartsWith("rois.stream."))
            {
                OnMedia?.Invoke(method, given);
            }
            _notices.Notify(method, given);
        }

        private async Task<HashSet<string>> HelloAsync(JsonRpcSession session, long within, CancellationToken token)
        {
            var hello = new HelloParams { Version = ExtensionVersion, Extensions = new List<string>(Spoken) };
            try
            {
                HelloResult answer = await RpcCall.AskAsync(session, Methods.Hello, hello, within, token);
                return new HashSet<string>(answer.Extensions);
            }
            catch (RpcException error) when (error.Code == JsonRpcMessage.MethodNotFound)
            {
                return new HashSet<string>();
            }
        }

        private void DirectoryChanged(DirectoryChangedNotification told)
        {
            Directory.NoteChanges(told);
            IEnumerable<string> named = told.Changed.Concat(told.Gone);
            ProfileChanged(new ProfileChange(told.Unnamed > 0 ? Enumerable.Empty<string>() : named));
        }

        private void ProfileChanged(ProfileChange change)
        {
            Generation++;
            _restorer.ProfileChanged(change);
            _notices.Notify(change);
            OnLeaseDoubtful?.Invoke(null);
        }

        private void BindingLost(BindingLoss loss)
        {
            _notices.Notify(loss);
            OnBindingLost?.Invoke(loss);
        }

        private void LeaseChanged(LeaseChangedNotification changed)
        {
            if (Bindings.HolderChanged(changed))
            {
                _restorer.BindMissing();
            }
            _notices.Notify(changed);
            OnLeaseChanged?.Invoke(changed);
        }

        private void Explain(JsonRpcSession session, ReasonNotification told)
        {
            string reason = RpcCall.OneLine(told.Reason);
            if (told.CommandId != null)
            {
                Commands.Explain(told.CommandId, reason);
            }
            if (told.RequestId is long)
            {
                session.Explain((long)told.RequestId, reason);
            }
        }

        private static void With<T>(JObject given, Action<T> handle)
            where T : class
        {
            T told = RpcCall.ReadNotification<T>(given);
            if (told != null)
            {
                handle(told);
            }
        }
    }
}
