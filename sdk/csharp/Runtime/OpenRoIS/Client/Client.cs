// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// A RoIS application's end of one gateway. It connects again by itself, resumes its session, and what it has bound
    /// and subscribed comes back with it; what does not is told by its events.
    /// <code>
    /// using (var client = new Client("ws://127.0.0.1:8765/"))
    /// {
    ///     await client.ConnectAsync();
    ///     using (Body body = await client.BodyAsync(Navigation.Type))
    ///     {
    ///         Navigation navigation = body.Part(Navigation.Type);
    ///         await navigation.SetAsync(targetPositions: new[] { "lobby" });
    ///         await navigation.StartAsync();
    ///     }
    /// }
    /// </code>
    /// </summary>
    public sealed class Client : Operations, IDisposable
    {
        private readonly ClientOptions _options;
        private readonly Bodies _bodies;

        /// <param name="url">the gateway: <c>ws://</c>, <c>wss://</c> or what it prints, <c>http://</c></param>
        /// <param name="options">how it connects; null for a gateway without tokens</param>
        /// <exception cref="ArgumentException">it is no address of a gateway, or carries a password; or an option cannot
        /// be</exception>
        public Client(string url = "ws://127.0.0.1:8765/", ClientOptions options = null)
            : this(AddressOf(url), (options ?? new ClientOptions()).Checked())
        {
        }

        private Client(Uri address, ClientOptions options)
            : base(options.Callbacks, options)
        {
            _options = options;
            Application = new Application(address, options, new Strand(options.Work, options.HandlerFailed), this);
            Control = new Control(Application);
            _bodies = new Bodies(this, Application, options.Timing);
        }

        /// <summary>Asks for components that others hold, hands them over, and stops everything.</summary>
        public Control Control { get; private set; }

        /// <summary>The state of the connection.</summary>
        public ConnectionState State
        {
            get { return Application.Connection.State; }
        }

        internal SynchronizationContext CallbackContext
        {
            get { return _options.Callbacks; }
        }

        internal Action<Exception> HandlerFailed
        {
            get { return _options.HandlerFailed; }
        }

        /// <summary>Connects, and stays connected until <see cref="CloseAsync"/>. After a failure it may be called again.</summary>
        /// <exception cref="ConnectionFailedException">there is no gateway, or it does not let this application in</exception>
        /// <exception cref="OperationCanceledException">the token ended it, or the client was closed meanwhile</exception>
        /// <exception cref="InvalidOperationException">it is connected, or was closed</exception>
        public Task ConnectAsync(CancellationToken token = default(CancellationToken))
        {
            return Application.Strand.Run(() => Application.Connection.OpenAsync(token));
        }

        /// <summary>
        /// Takes leave of the gateway, for at most two seconds: nothing stays bound, commands that run go on. Idempotent.
        /// </summary>
        public Task CloseAsync()
        {
            return Application.Strand.Run(() => Application.Connection.CloseAsync());
        }

        /// <summary>Closes without waiting.</summary>
        public void Dispose()
        {
            CloseAsync().LetRun();
        }

        /// <summary>Returns the component of a type with this reference, without a request.</summary>
        public T Component<T>(ComponentType<T> type, string componentRef)
            where T : ComponentProxy
        {
            return type.MakeProxy(this, componentRef);
        }

        /// <summary>Returns the one component of a type, or the one of them that meets a condition.</summary>
        /// <exception cref="UnsupportedException">there is none</exception>
        /// <exception cref="BadParameterException">there are several; it says which, and how to choose</exception>
        public async Task<T> FindAsync<T>(
            ComponentType<T> type, string condition = "", CancellationToken token = default(CancellationToken))
            where T : ComponentProxy
        {
            IReadOnlyList<T> found = await FindAllAsync(type, condition, token);
            if (found.Count == 0)
            {
                throw new UnsupportedException("there is no " + type + (condition == "" ? "" : " where " + condition));
            }
            if (found.Count > 1)
            {
                throw new BadParameterException(
                    "there are " + found.Count + " components " + type + ": "
                    + string.Join(", ", found.Select(each => each.ComponentRef)) + "; take one that is free by BodyAsync("
                    + type + ".Type), or name one: Condition.ComponentRef(\"" + found[0].ComponentRef + "\")");
            }
            return found[0];
        }

        /// <summary>Returns the components of a type that meet a condition, in the order of the profile.</summary>
        public async Task<IReadOnlyList<T>> FindAllAsync<T>(
            ComponentType<T> type, string condition = "", CancellationToken token = default(CancellationToken))
            where T : ComponentProxy
        {
            IEnumerable<string> refs = await SearchAsync(Condition.And(Condition.ComponentType(type.Urn), condition), token);
            if (!refs.Any())
            {
                // Some gateways compare the code of the identifier alone with the URN.
                refs = (await GetProfileAsync(condition, token)).ComponentProfiles
                    .Where(each => BodyDirectory.UrnOf(each.Value) == type.Urn).Select(each => each.Key);
            }
            return refs.Select(componentRef => type.MakeProxy(this, componentRef)).ToList();
        }

        /// <summary>
        /// Returns the bodies behind the gateway: what each can do, and whether it is free. A body is an engine that owns
        /// components, with all that is reachable through it.
        /// </summary>
        public Task<IReadOnlyList<BodyInfo>> BodiesAsync(CancellationToken token = default(CancellationToken))
        {
            return Application.Strand.Run(() => _bodies.AllAsync(token));
        }

        /// <summary>
        /// Reserves a body that has components of these types, until what comes back is disposed of; otherwise as
        /// <see cref="BodyAsync(BodyRequest, CancellationToken)"/> with a wait of ten seconds.
        /// </summary>
        public Task<Body> BodyAsync(params ComponentType[] required)
        {
            return BodyAsync(new BodyRequest(required), CancellationToken.None);
        }

        /// <summary>
        /// Reserves a body: all components are bound of one body, or none. Of several bodies the first that is free is taken,
        /// those with more of the optional types first; of several components of a type in it the first by reference. A body
        /// whose required component is lost is given back, and <see cref="ClientNotices.BodyLost"/> tells.
        /// </summary>
        /// <exception cref="OutOfResourcesException">all that have the components are taken; it says which refused</exception>
        /// <exception cref="UnsupportedException">there is no such body; it says which there are</exception>
        /// <exception cref="BadParameterException">the condition is none</exception>
        /// <exception cref="ArgumentException">no type is required, or one is named twice</exception>
        /// <exception cref="TimeoutException">there was no connection for <see cref="ClientOptions.RequestTimeout"/>, however
        /// long the wait may be</exception>
        public Task<Body> BodyAsync(BodyRequest request, CancellationToken token = default(CancellationToken))
        {
            request.Check();
            return Application.Strand.Run(() => _bodies.ReserveAsync(request, token));
        }

        private static Uri AddressOf(string url)
        {
            Uri address;
            if (!Uri.TryCreate(url, UriKind.Absolute, out address)
                || !new[] { "ws", "wss", "http", "https" }.Contains(address.Scheme))
            {
                throw new ArgumentException(
                    "\"" + url + "\" is no address of a gateway: give one such as ws://127.0.0.1:8765/");
            }
            if (address.UserInfo != "")
            {
                throw new ArgumentException(
                    "credentials do not belong in an address, where logs would keep them: set ClientOptions.Token");
            }
            var websocket = new UriBuilder(address) { Fragment = "" };
            websocket.Scheme = address.Scheme.Replace("http", "ws");
            websocket.Port = address.IsDefaultPort ? (websocket.Scheme == "wss" ? 443 : 80) : address.Port;
            return websocket.Uri;
        }
    }
}
