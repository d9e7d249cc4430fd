using System;
using System.IO;
using System.Threading;
using System.Threading.Tasks;
using UnityEngine;

namespace OpenRoIS.Unity
{
    /// <summary>
    /// Connects a scene to a gateway, and again whenever there is none. All handlers of the client's events are called on the
    /// main thread, in this component's <c>Update</c>, which comes before that of other scripts; none while it is disabled.
    /// </summary>
    [DefaultExecutionOrder(-1000)]
    [AddComponentMenu("OpenRoIS/OpenRoIS Client")]
    public sealed class OpenRoISClient : MonoBehaviour
    {
        /// <summary>Milliseconds between two attempts while there was no connection yet.</summary>
        private const int Patience = 2000;

        [Tooltip("The gateway: ws://, wss:// or http://host:port/")]
        public string Address = "ws://127.0.0.1:8765/";

        [Tooltip("The file with the token, where the gateway wants one; read anew at each connection")]
        public string TokenFile = "";

        private readonly CancellationTokenSource _destroyed = new CancellationTokenSource();
        private readonly TaskCompletionSource<Client> _connected =
            new TaskCompletionSource<Client>(TaskCreationOptions.RunContinuationsAsynchronously);
        private Dispatcher _dispatcher;
        private ITiming _timing = SystemTiming.Instance;
        private Action _pumpTiming = () => { };

        /// <summary>
        /// Returns the newest token, in place of the file: set it in <c>Awake</c> of a script of your own. It is called on a
        /// thread of the pool, where most of Unity must not be used.
        /// </summary>
        public Func<string> Token { get; set; }

        /// <summary>Opens connections: in a browser (WebGL) there is none of .NET, and this must be set in <c>Awake</c>.</summary>
        public ITransport Transport { get; set; }

        /// <summary>The client, from <c>Start</c> on; to be used once it is connected.</summary>
        public Client Client { get; private set; }

        /// <summary>Returns the client once it is connected for the first time.</summary>
        /// <exception cref="OperationCanceledException">the scene has ended first</exception>
        /// <exception cref="ArgumentException"><see cref="Address"/> is no address of a gateway, or a browser lacks its
        /// <see cref="Transport"/></exception>
        /// <exception cref="ConnectionFailedException">the gateway does not let this application in</exception>
        public Task<Client> ConnectedAsync()
        {
            return _connected.Task;
        }

        private void Start()
        {
            _dispatcher = new Dispatcher(Debug.LogException);
            var options = new ClientOptions
            {
                Callbacks = _dispatcher,
                HandlerFailed = Debug.LogException,
                Token = Token ?? (TokenFile == "" ? null : new Func<string>(ReadToken))
            };
#if UNITY_WEBGL && !UNITY_EDITOR
            var timing = new PumpedTiming(() => (long)(1000 * Time.realtimeSinceStartupAsDouble));
            options.Timing = _timing = timing;
            _pumpTiming = timing.Pump;
            options.Work = _dispatcher;
#endif
            if (Transport != null)
            {
                options.Transport = Transport;
            }
            try
            {
#if UNITY_WEBGL && !UNITY_EDITOR
                if (Transport == null)
                {
                    throw new ArgumentException(
                        "a browser has no sockets of .NET: set OpenRoISClient.Transport in Awake of a script of your own");
                }
#endif
                Client = new Client(Address, options);
            }
            catch (ArgumentException error)
            {
                _connected.TrySetException(error);
                throw;
            }
            Client.ConnectionChanged += LogEnd;
            Connect();
        }

        private void Update()
        {
            _pumpTiming();
            _dispatcher.Pump();
        }

        private void OnDestroy()
        {
            _destroyed.Cancel();
            _connected.TrySetCanceled();
            Client?.Dispose();
        }

        private async void Connect()
        {
            while (!_destroyed.IsCancellationRequested)
            {
                try
                {
                    await Client.ConnectAsync(_destroyed.Token);
                    _connected.TrySetResult(Client);
                    return;
                }
                catch (ConnectionFailedException error)
                {
                    Debug.LogWarning("OpenRoIS: " + error.Message);
                    if (error.Final)
                    {
                        _connected.TrySetException(error);
                        return;
                    }
                }
                catch (OperationCanceledException)
                {
                    return;
                }
                await Pause();
            }
        }

        private async Task Pause()
        {
            var over = new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);
            using (_timing.After(Patience, () => over.TrySetResult(true)))
            using (_destroyed.Token.Register(() => over.TrySetResult(true)))
            {
                await over.Task;
            }
        }

        private string ReadToken()
        {
            return File.ReadAllText(TokenFile);
        }

        private static void LogEnd(ConnectionChange change)
        {
            // It ended; for good where the state is Closed.
            if (change.Reason != "")
            {
                Debug.LogWarning("OpenRoIS: " + change.Reason);
            }
        }
    }
}
