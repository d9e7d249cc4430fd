// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;

namespace OpenRoIS
{
    /// <summary>How a connection has ended.</summary>
    public struct Closing
    {
        internal Closing(int code, string reason)
            : this()
        {
            Code = code;
            Reason = reason;
        }

        /// <summary>The WebSocket's code; 1006 where the connection broke.</summary>
        public int Code { get; private set; }

        public string Reason { get; private set; }

        public override string ToString()
        {
            return string.IsNullOrEmpty(Reason) ? "closed (" + Code + ")" : Reason + " (" + Code + ")";
        }
    }

    /// <summary>Answers the other side's requests: method and params in, result out.</summary>
    /// <exception cref="RpcException">is sent as it is; any other exception as an internal error</exception>
    public delegate Task<JToken> RequestHandler(string method, JObject given);

    /// <summary>
    /// JSON-RPC 2.0 both ways over one socket, until that closes. Everything of it runs in one <see cref="Strand"/>, its
    /// callbacks too: results and notifications are offered in the order of their arrival, before the next message is read.
    /// </summary>
    public sealed class JsonRpcSession
    {
        /// <summary>Requests of this side that may be unanswered.</summary>
        public const int MostOutstanding = 256;

        /// <summary>Requests of the other side that may run here.</summary>
        public const int MostServed = 64;

        /// <summary>Messages and characters that may wait to be sent.</summary>
        public const int MostQueued = 1024;

        /// <summary>Characters that may wait to be sent.</summary>
        public const int MostQueuedText = 4 * 1024 * 1024;

        /// <summary>Late answers that are still taken; the oldest is given up first.</summary>
        private const int MostLate = 64;

        private const int Busy = -32000;

        private readonly IMessageSocket _socket;
        private readonly Strand _strand;
        private readonly ITiming _timing;
        private readonly Dictionary<long, Waiter> _waiters = new Dictionary<long, Waiter>();
        private readonly Dictionary<long, Action<JToken>> _late = new Dictionary<long, Action<JToken>>();
        private readonly Queue<long> _lateOrder = new Queue<long>();
        private readonly TaskCompletionSource<bool> _over =
            new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);
        private readonly Queue<string> _outgoing = new Queue<string>();
        private int _outgoingText;
        private bool _sending;
        private long _lastId;
        private int _served;
        private bool _closed;
        private long _receivedAt;

        public JsonRpcSession(IMessageSocket socket, Strand strand, ITiming timing)
        {
            _socket = socket;
            _strand = strand;
            _timing = timing;
            _receivedAt = timing.Milliseconds;
        }

        /// <summary>Takes each notification of the other side.</summary>
        public Action<string, JObject> NotificationHandler { get; set; }

        /// <summary>Answers the other side's requests; without one all methods are unknown.</summary>
        public RequestHandler RequestHandler { get; set; }

        /// <summary>Takes a sentence about each message that was none; it is answered as the protocol says.</summary>
        public Action<string> ViolationHandler { get; set; }

        /// <summary>Takes what a handler of this side, or the socket, has thrown; that ends nothing else.</summary>
        public Action<Exception> FailureHandler { get; set; }

        /// <summary>Milliseconds since the last message came in.</summary>
        public long Silence
        {
            get { return _timing.Milliseconds - _receivedAt; }
        }

        /// <summary>Reads until the connection is over, and returns how it ended. Every request has ended then.</summary>
        public async Task<Closing> RunAsync()
        {
            while (!_closed)
            {
                Task<string> receiving = _socket.ReceiveAsync();
                // Not every socket that is closed here ends what waits for its next message.
                await Task.WhenAny(receiving, _over.Task);
                string text = receiving.IsCompleted ? await Received(receiving) : null;
                if (text == null || _closed)
                {
                    break;
                }
                _receivedAt = _timing.Milliseconds;
                Receive(JsonRpcMessage.Read(text));
            }
            var closing = new Closing(_socket.CloseCode, _socket.CloseReason);
            End(closing);
            _socket.Dispose();
            return closing;
        }

        /// <summary>Asks the other side, and waits for its result.</summary>
        /// <param name="method">its name</param>
        /// <param name="given">its params</param>
        /// <param name="within">milliseconds to wait at most</param>
        /// <param name="token">ends the wait</param>
        /// <param name="onResult">takes the result, and what <see cref="Explain"/> said of it, before any later message is
        /// read; what it throws is what the caller gets</param>
        /// <param name="onLate">takes a result for which nothing waits any more, to undo what was done</param>
        /// <exception cref="RpcException">the other side refuses</exception>
        /// <exception cref="ConnectionLostException">the connection ended first</exception>
        /// <exception cref="TimeoutException">no answer in time, or too many requests wait for theirs</exception>
        /// <exception cref="OperationCanceledException">the token ended the wait</exception>
        public async Task RequestAsync(
            string method,
            JObject given,
            long within,
            CancellationToken token,
            Action<JToken, string> onResult,
            Action<JToken> onLate = null)
        {
            token.ThrowIfCancellationRequested();
            if (_closed)
            {
                throw new ConnectionLostException(method + ": the connection has ended");
            }
            if (_waiters.Count >= MostOutstanding)
            {
                throw new TimeoutException(
                    method + ": " + MostOutstanding + " requests are unanswered: await some answers first");
            }
            long id = ++_lastId;
            var waiter = new Waiter(method, onResult, onLate);
            _waiters.Add(id, waiter);
            string late = method + ": no answer within " + within + " ms";
            using (_timing.After(within, () => _strand.Post(() => GiveUp(id, new TimeoutException(late), within))))
            using (token.Register(() => _strand.Post(() => GiveUp(id, new OperationCanceledException(token), -1))))
            {
                Send(JsonRpcMessage.WriteRequest(id, method, given));
                await waiter.Done.Task;
            }
        }

        /// <summary>Asks, and drops the answer.</summary>
        public void Post(string method, JObject given)
        {
            if (!_closed)
            {
                Send(JsonRpcMessage.WriteRequest(++_lastId, method, given));
            }
        }

        /// <summary>Notifies the other side.</summary>
        public void Notify(string method, JObject given)
        {
            if (!_closed)
            {
                Send(JsonRpcMessage.WriteNotification(method, given));
            }
        }

        /// <summary>Notes why a request is about to be refused; ignored for one that nothing waits for.</summary>
        public void Explain(long id, string reason)
        {
            Waiter waiter;
            if (_waiters.TryGetValue(id, out waiter))
            {
                waiter.Reason = reason;
            }
        }

        /// <summary>Closes the connection; what waits for an answer fails at once.</summary>
        public async Task CloseAsync(int code, string reason)
        {
            End(new Closing(code, reason));
            await _socket.CloseAsync(code, reason);
            _over.TrySetResult(true);
        }

        private async Task<string> Received(Task<string> receiving)
        {
            try
            {
                return await receiving;
            }
            catch (Exception error)
            {
                // A socket throws nothing here. One that does is over.
                FailureHandler?.Invoke(error);
                return null;
            }
        }

        private void Receive(JsonRpcMessage message)
        {
            try
            {
                Handle(message);
            }
            catch (Exception error)
            {
                FailureHandler?.Invoke(error);
            }
        }

        private void Handle(JsonRpcMessage message)
        {
            switch (message.Kind)
            {
                case JsonRpcKind.Notification:
                    NotificationHandler?.Invoke(message.Method, message.Params);
                    break;
                case JsonRpcKind.Request:
                    Serve(message);
                    break;
                case JsonRpcKind.Violation:
                    ViolationHandler?.Invoke(message.Wrong);
                    if (message.WrongCode != 0)
                    {
                        Send(JsonRpcMessage.WriteError(message.Id, message.WrongCode, message.Wrong));
                    }
                    break;
                default:
                    TakeAnswer(message);
                    break;
            }
        }

        private void TakeAnswer(JsonRpcMessage message)
        {
            long id = message.Id != null && message.Id.Type == JTokenType.Integer ? IdOf(message.Id) : 0;
            Waiter waiter;
            Action<JToken> late;
            if (_waiters.TryGetValue(id, out waiter))
            {
                _waiters.Remove(id);
                waiter.Settle(message);
            }
            else if (_late.TryGetValue(id, out late))
            {
                _late.Remove(id);
                if (message.Kind == JsonRpcKind.Response)
                {
                    late(message.Result);
                }
            }
        }

        private static long IdOf(JToken id)
        {
            // One of more than 64 bits is none of ours.
            var value = (JValue)id;
            return value.Value is long ? (long)value.Value : 0;
        }

        private async void Serve(JsonRpcMessage request)
        {
            if (RequestHandler == null)
            {
                Send(JsonRpcMessage.WriteError(request.Id, JsonRpcMessage.MethodNotFound, "Method not found"));
                return;
            }
            if (_served >= MostServed)
            {
                Send(JsonRpcMessage.WriteError(request.Id, Busy, MostServed + " requests are running: ask later"));
                return;
            }
            _served++;
            string answer;
            try
            {
                answer = JsonRpcMessage.WriteResponse(request.Id, await RequestHandler(request.Method, request.Params));
            }
            catch (RpcException error)
            {
                answer = JsonRpcMessage.WriteError(request.Id, (int)error.Code, error.Message);
            }
            catch (Exception)
            {
                // What has failed here is no business of the other side.
                answer = JsonRpcMessage.WriteError(request.Id, JsonRpcMessage.InternalError, "Internal error");
            }
            _served--;
            Send(answer);
        }

        private void Send(string text)
        {
            if (_closed)
            {
                return;
            }
            if (_outgoing.Count >= MostQueued || _outgoingText + text.Length > MostQueuedText)
            {
                // The other side does not read: nothing that is sent now would arrive in time.
                CloseAsync(4000, "the other side does not read").LetRun();
                return;
            }
            _outgoing.Enqueue(text);
            _outgoingText += text.Length;
            if (!_sending)
            {
                SendQueued();
            }
        }

        private async void SendQueued()
        {
            _sending = true;
            try
            {
                while (_outgoing.Count > 0 && !_closed)
                {
                    string text = _outgoing.Dequeue();
                    _outgoingText -= text.Length;
                    await _socket.SendAsync(text);
                }
            }
            catch (Exception)
            {
                // The end of the connection is noticed by its reader, with the reason.
                _outgoing.Clear();
                _outgoingText = 0;
            }
            _sending = false;
        }

        private void GiveUp(long id, Exception error, long silentFor)
        {
            Waiter waiter;
            if (!_waiters.TryGetValue(id, out waiter))
            {
                return;
            }
            _waiters.Remove(id);
            if (waiter.OnLate != null)
            {
                _late[id] = waiter.OnLate;
                _lateOrder.Enqueue(id);
                if (_lateOrder.Count > MostLate)
                {
                    _late.Remove(_lateOrder.Dequeue());
                }
            }
            waiter.Done.TrySetException(error);
            if (silentFor > 0 && Silence >= silentFor)
            {
                // A connection on which nothing at all comes in any more is dead, though the system cannot know it yet.
                CloseAsync(4000, "no answer").LetRun();
            }
        }

        private void End(Closing closing)
        {
            if (_closed)
            {
                return;
            }
            _closed = true;
            _late.Clear();
            var waiters = new List<Waiter>(_waiters.Values);
            _waiters.Clear();
            foreach (Waiter waiter in waiters)
            {
                waiter.Done.TrySetException(new ConnectionLostException(
                    waiter.Method + ": the connection ended before the answer came (" + closing + ")"));
            }
        }

        private sealed class Waiter
        {
            internal readonly string Method;
            internal readonly Action<JToken> OnLate;
            internal readonly TaskCompletionSource<bool> Done =
                new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);

            private readonly Action<JToken, string> _onResult;

            internal Waiter(string method, Action<JToken, string> onResult, Action<JToken> onLate)
            {
                Method = method;
                OnLate = onLate;
                _onResult = onResult;
            }

            internal string Reason { get; set; }

            internal void Settle(JsonRpcMessage message)
            {
                try
                {
                    if (message.Kind == JsonRpcKind.Error)
                    {
                        throw new RpcException(Method, message.Error);
                    }
                    _onResult(message.Result, Reason ?? "");
                    Done.TrySetResult(true);
                }
                catch (Exception error)
                {
                    Done.TrySetException(error);
                }
            }
        }
    }
}
