// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;

namespace OpenRoIS
{
    /// <summary>What is carried from one connection to the next.</summary>
    internal interface IConnectionOwner
    {
        /// <summary>Begins a session. What it throws ends the attempt.</summary>
        Task GreetAsync(JsonRpcSession session, CancellationToken token);

        /// <summary>Works beside the application until the token says that the connection has ended.</summary>
        Task RunBackgroundAsync(JsonRpcSession session, CancellationToken token);

        void HandleNotification(JsonRpcSession session, string method, JObject given);

        /// <param name="reason">why it ended, one sentence</param>
        /// <param name="lost">it was not closed, so that its session may be resumed</param>
        /// <param name="again">another connection follows</param>
        void ConnectionEnded(string reason, bool lost, bool again);

        void ConnectionChanged(ConnectionState state, string reason, TimeSpan? retryIn);

        /// <summary>There will be no connection any more, as it was closed, or for an error.</summary>
        void Closed(Exception error);
    }

    /// <summary>
    /// A connection that hides its interruptions. All of it runs in the client's strand.
    /// </summary>
    internal sealed class Connection
    {
        private const int Broken = 1006;
        private const int TokenEnded = 4401;

        /// <summary>Another connection has resumed the session of this one.</summary>
        private const int Resumed = 4409;
        private const long Farewell = 1000;

        private readonly Uri _address;
        private readonly ClientOptions _options;
        private readonly Strand _strand;
        private readonly IConnectionOwner _owner;
        private readonly CancellationTokenSource _over = new CancellationTokenSource();
        private JsonRpcSession _session;
        private TaskCompletionSource<bool> _changed = NewSignal();
        private Task _supervising;
        private string _overBecause;

        internal Connection(Uri address, ClientOptions options, Strand strand, IConnectionOwner owner)
        {
            _address = address;
            _options = options;
            _strand = strand;
            _owner = owner;
        }

        internal ConnectionState State { get; private set; }

        internal long RequestTimeout
        {
            get { return (long)_options.RequestTimeout.TotalMilliseconds; }
        }

        /// <summary>Connects for the first time, and from then on again and again.</summary>
        /// <exception cref="ConnectionFailedException">the first attempt has failed; another call may follow</exception>
        internal async Task OpenAsync(CancellationToken token)
        {
            if (_supervising != null || _overBecause != null)
            {
                throw new InvalidOperationException(
                    "this client is connected, or was closed: make another one for another connection");
            }
            using (CancellationTokenSource either = CancellationTokenSource.CreateLinkedTokenSource(token, _over.Token))
            {
                // Noted first: a second call must not connect beside this one.
                var opened = NewSignal();
                _supervising = opened.Task;
                try
                {
                    Live first = await BeginAsync(either.Token);
                    _supervising = SuperviseAsync(first);
                }
                catch (Exception)
                {
                    _supervising = null;
                    Enter(ConnectionState.Closed, "", null);
                    throw;
                }
                finally
                {
                    opened.TrySetResult(true);
                }
            }
        }

        /// <summary>Takes leave of the gateway, for at most two seconds, and ends the connection. Idempotent.</summary>
        internal async Task CloseAsync()
        {
            _overBecause = _overBecause ?? "the client is closed";
            // First: what ends now is not made again.
            _over.Cancel();
            JsonRpcSession session = _session;
            if (session != null)
            {
                try
                {
                    await RpcCall.AskAsync(
                        session, Methods.SystemDisconnect, new NoParams(), Farewell, CancellationToken.None);
                }
                catch (Exception)
                {
                    // The end of the connection says the same.
                }
                await session.CloseAsync(1000, "client closed");
            }
            if (_supervising != null)
            {
                await _supervising;
            }
        }

        /// <summary>
        /// Sends a request that may be repeated: without a connection it waits for one, and is repeated where one ended.
        /// </summary>
        internal async Task<TResult> AskAsync<TParams, TResult>(
            Method<TParams, TResult> method,
            TParams given,
            CancellationToken token,
            Action<TResult> accepted = null,
            Action<TResult> tooLate = null)
            where TResult : class, IOutcome
        {
            long deadline = _options.Timing.Milliseconds + RequestTimeout;
            while (true)
            {
                JsonRpcSession session = await ConnectedAsync(method.Name, deadline, token);
                long left = Math.Max(deadline - _options.Timing.Milliseconds, 1);
                try
                {
                    return await RpcCall.AskAsync(session, method, given, left, token, accepted, tooLate);
                }
                catch (ConnectionLostException)
                {
                    DropSession(session);
                }
            }
        }

        /// <summary>Sends a request on this connection or not at all: what moves a robot is not kept for later.</summary>
        /// <exception cref="ConnectionLostException">there is none, or it ended first</exception>
        internal Task<TResult> ActAsync<TParams, TResult>(
            Method<TParams, TResult> method,
            TParams given,
            CancellationToken token,
            Action<TResult> accepted = null,
            Action<TResult> tooLate = null)
            where TResult : class, IOutcome
        {
            return RpcCall.AskAsync(
                RequireSession(method.Name), method, given, RequestTimeout, token, accepted, tooLate);
        }

        /// <summary>Sends a request and drops its answer; nothing happens without a connection.</summary>
        internal void Post<TParams, TResult>(Method<TParams, TResult> method, TParams given)
        {
            _session?.Post(method.Name, RoISJson.ToObject(given));
        }

        internal JsonRpcSession RequireSession(string doing)
        {
            RequireOpen(doing);
            if (_session == null)
            {
                throw new ConnectionLostException(
                    doing + ": there is no connection, and commands are not kept for later: try again once there is one");
            }
            return _session;
        }

        private void RequireOpen(string doing)
        {
            if (_overBecause != null || _supervising == null)
            {
                string why = _overBecause ?? "the client is not connected: call ConnectAsync first";
                throw new ConnectionLostException(doing + ": " + why);
            }
        }

        private async Task<JsonRpcSession> ConnectedAsync(string method, long deadline, CancellationToken token)
        {
            while (true)
            {
                RequireOpen(method);
                if (_session != null)
                {
                    return _session;
                }
                long left = deadline - _options.Timing.Milliseconds;
                if (left <= 0)
                {
                    throw new TimeoutException(method + ": no connection within " + RequestTimeout + " ms");
                }
                TaskCompletionSource<bool> late = NewSignal();
                using (_options.Timing.After(left, () => late.TrySetResult(true)))
                {
                    await Task.WhenAny(_changed.Task, late.Task).OrCanceled(token);
                }
            }
        }

        private async Task SuperviseAsync(Live first)
        {
            Exception failure = null;
            try
            {
                await KeepConnectedAsync(first);
            }
            catch (OperationCanceledException)
            {
                // It was closed.
            }
            catch (Exception error)
            {
                failure = error;
            }
            bool closed = _overBecause != null;
            _overBecause = _overBecause ?? failure?.Message ?? "the client is closed";
            _session = null;
            _owner.ConnectionEnded(_overBecause, false, false);
            Enter(ConnectionState.Closed, _overBecause, null);
            _owner.Closed(closed ? null : new ConnectionLostException(_overBecause));
            Signal();
        }

        /// <summary>Connects again and again; an exception ends that for good.</summary>
        private async Task KeepConnectedAsync(Live live)
        {
            Backoff backoff = _options.Reconnect.Begin();
            while (true)
            {
                long lasted = 0;
                Closing closing;
                string reason;
                if (live != null)
                {
                    closing = await LiveAsync(live);
                    lasted = _options.Timing.Milliseconds - live.Since;
                    reason = "the connection ended: " + closing;
                    if (closing.Code == TokenEnded && _options.Token == null)
                    {
                        throw new ConnectionFailedException(
                            "the gateway does not let this application in any more: " + closing.Reason, true);
                    }
                    live = null;
                }
                else
                {
                    try
                    {
                        live = await BeginAsync(_over.Token);
                        continue;
                    }
                    catch (ConnectionFailedException error) when (!error.Final)
                    {
                        closing = new Closing(Broken, "");
                        reason = error.Message;
                    }
                }
                _over.Token.ThrowIfCancellationRequested();
                // Both: a time that all clients get alike must not bring them back at the same moment.
                long wait = backoff.After(lasted) + Reconnect.AskedToWait(closing.Reason);
                Enter(ConnectionState.Waiting, reason, TimeSpan.FromMilliseconds(wait));
                await _options.Timing.DelayAsync(wait, _over.Token);
            }
        }

        /// <summary>Makes one attempt.</summary>
        private async Task<Live> BeginAsync(CancellationToken token)
        {
            Enter(ConnectionState.Connecting, "", null);
            long within = (long)_options.ConnectTimeout.TotalMilliseconds;
            using (var late = new CancellationTokenSource())
            using (CancellationTokenSource either = CancellationTokenSource.CreateLinkedTokenSource(token, late.Token))
            using (_options.Timing.After(within, late.CancelIfThere))
            {
                try
                {
                    return await GreetAsync(either.Token);
                }
                catch (OperationCanceledException)
                {
                    token.ThrowIfCancellationRequested();
                    throw new ConnectionFailedException("the gateway did not answer within " + within + " ms");
                }
                catch (Exception error) when (!(error is ConnectionFailedException))
                {
                    var rpc = error as RpcException;
                    bool stranger = rpc != null && rpc.Code == JsonRpcMessage.MethodNotFound;
                    throw new ConnectionFailedException(
                        (stranger ? "what answers does not serve applications: " : "no connection to the gateway: ")
                        + error.Message);
                }
            }
        }

        private async Task<Live> GreetAsync(CancellationToken token)
        {
            IMessageSocket socket = await OpenSocketAsync(token);
            var session = new JsonRpcSession(socket, _strand, _options.Timing) { FailureHandler = _options.HandlerFailed };
            session.NotificationHandler = (method, given) => _owner.HandleNotification(session, method, given);
            Task<Closing> running = session.RunAsync();
            try
            {
                await _owner.GreetAsync(session, token);
            }
            catch (Exception)
            {
                session.CloseAsync(4001, "the client's greeting has failed").LetRun();
                throw;
            }
            return new Live(session, running, _options.Timing.Milliseconds);
        }

        private async Task<IMessageSocket> OpenSocketAsync(CancellationToken token)
        {
            Task<IMessageSocket> opening = _options.Transport.OpenAsync(_address, NewestToken(), token);
            try
            {
                return await opening.OrCanceled(token);
            }
            catch (OperationCanceledException)
            {
                // Not every platform heeds the token at once.
                DisposeOf(opening).LetRun();
                throw;
            }
        }

        private static async Task DisposeOf(Task<IMessageSocket> opening)
        {
            (await opening).Dispose();
        }

        private string NewestToken()
        {
            return _options.Token == null ? null : Tokens.Read(_options.Token);
        }

        private async Task<Closing> LiveAsync(Live live)
        {
            using (var ended = new CancellationTokenSource())
            {
                _session = live.Session;
                Enter(ConnectionState.Connected, "", null);
                Signal();
                if (_overBecause != null)
                {
                    // It was closed while it was being opened.
                    live.Session.CloseAsync(1000, "client closed").LetRun();
                }
                Task background = _owner.RunBackgroundAsync(live.Session, ended.Token);
                Task probing = ProbeAsync(live.Session, ended.Token);
                Closing closing = await live.Running;
                DropSession(live.Session);
                ended.Cancel();
                bool again = _overBecause == null;
                _owner.ConnectionEnded(
                    "the connection ended: " + closing, again && closing.Code != Resumed, again);
                await Quiet(background);
                await Quiet(probing);
                return closing;
            }
        }

        /// <summary>Only a request that is not answered shows that a silent connection is dead.</summary>
        private async Task ProbeAsync(JsonRpcSession session, CancellationToken token)
        {
            long idle = (long)_options.IdleProbe.TotalMilliseconds;
            var nothing = new ConditionParams { Condition = Condition.ComponentRef("") };
            while (true)
            {
                await _options.Timing.DelayAsync(Math.Max(idle - session.Silence, 1), token);
                if (session.Silence >= idle)
                {
                    await Quiet(RpcCall.AskAsync(session, Methods.CommandSearch, nothing, RequestTimeout, token));
                }
            }
        }

        private static async Task Quiet(Task task)
        {
            try
            {
                await task;
            }
            catch (Exception)
            {
                // It ends with its connection.
            }
        }

        private void DropSession(JsonRpcSession session)
        {
            if (_session == session)
            {
                _session = null;
            }
        }

        private void Enter(ConnectionState state, string reason, TimeSpan? retryIn)
        {
            State = state;
            _owner.ConnectionChanged(state, reason, retryIn);
        }

        private void Signal()
        {
            TaskCompletionSource<bool> changed = _changed;
            _changed = NewSignal();
            changed.TrySetResult(true);
        }

        private static TaskCompletionSource<bool> NewSignal()
        {
            return new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);
        }

        /// <summary>A connection that is open.</summary>
        private sealed class Live
        {
            internal readonly JsonRpcSession Session;
            internal readonly Task<Closing> Running;
            internal readonly long Since;

            internal Live(JsonRpcSession session, Task<Closing> running, long since)
            {
                Session = session;
                Running = running;
                Since = since;
            }
        }
    }
}
