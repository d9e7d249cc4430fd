// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;

namespace OpenRoIS.Media
{
    /// <summary>
    /// Negotiates the media of a client's streams: one peer connection for each engine. Make it before the first stream is
    /// connected. When the client's connection ends all peers are closed, and the streams are over: connect them again once
    /// <see cref="ClientNotices.ConnectionChanged"/> tells of another one.
    /// </summary>
    public sealed class MediaSession : IDisposable
    {
        private static readonly IceServer[] NoServers = new IceServer[0];

        /// <summary>Calls of peers that may wait in the context of the application's callbacks.</summary>
        private const int MostWaiting = 128;

        /// <summary>Used in the context of the application's callbacks, and by <see cref="Dispose"/>: under its lock.</summary>
        private readonly Dictionary<string, IMediaPeer> _peers = new Dictionary<string, IMediaPeer>();

        private readonly Negotiation _negotiation = new Negotiation();
        private readonly Func<MediaPeerRequest, IMediaPeer> _open;
        private readonly Client _client;
        private readonly Application _application;
        private readonly Callbacks<StreamStatusNotification> _statuses;
        private IReadOnlyList<IceServer> _servers = NoServers;
        private long _serversUntil = long.MinValue;
        private Task _turn = Task.FromResult(true);
        private int _waiting;
        private bool _isDisposed;

        /// <param name="client">whose streams these are</param>
        /// <param name="open">makes a peer connection; called in the context of the client's callbacks</param>
        public MediaSession(Client client, Func<MediaPeerRequest, IMediaPeer> open)
        {
            const int buffer = 256;
            _client = client;
            _open = open;
            _application = client.Application;
            _statuses = new Callbacks<StreamStatusNotification>(
                client.CallbackContext, told => StreamStatusChanged?.Invoke(told), client.HandlerFailed, buffer);
            _application.Strand.Post(() =>
            {
                _application.OnMedia += TakeNotification;
                _application.OnConnectionEnded += ConnectionEnded;
            });
        }

        /// <summary>
        /// One of this application's streams has another status. It comes in the context of the client's callbacks;
        /// <c>StreamingNotConnected</c> says that the stream is over, and its id unknown.
        /// </summary>
        public event Action<StreamStatusNotification> StreamStatusChanged;

        /// <summary>
        /// Ends all peers, before it returns: to be called where callbacks come, in Unity on the main thread. The streams are
        /// the application's to disconnect.
        /// </summary>
        public void Dispose()
        {
            List<IMediaPeer> open;
            lock (_peers)
            {
                _isDisposed = true;
                open = _peers.Values.ToList();
                _peers.Clear();
            }
            foreach (IMediaPeer peer in open)
            {
                Close(peer);
            }
            _application.Strand.Post(() =>
            {
                _application.OnMedia -= TakeNotification;
                _application.OnConnectionEnded -= ConnectionEnded;
                Run(_negotiation.EndedAll("the media session is closed"));
            });
        }

        private void TakeNotification(string method, JObject given)
        {
            if (method == Notifications.SignalingOffer.Name)
            {
                With<Offer>(given, offer => _turn = TakeOffer(_turn, offer));
            }
            else if (method == Notifications.SignalingCandidate.Name)
            {
                With<Candidate>(given, candidate => _turn = After(_turn, () => _negotiation.Received(candidate)));
            }
            else if (method == Notifications.SignalingBye.Name)
            {
                With<Bye>(given, bye => _turn = After(_turn, () => _negotiation.Ended(bye.PeerId, bye.Reason)));
            }
            else if (method == Notifications.StreamNotifyStreamStatus.Name)
            {
                With<StreamStatusNotification>(given, _statuses.Offer);
            }
        }

        /// <summary>What belongs to an offer comes after it, however long that is prepared.</summary>
        private async Task After(Task before, Func<IEnumerable<Effect>> take)
        {
            await before;
            Run(take());
        }

        /// <summary>Takes an offer once it is known by which servers the peer can be reached; in the order of offers.</summary>
        private async Task TakeOffer(Task before, Offer offer)
        {
            await before;
            if (_application.Connection.State == ConnectionState.Connected && _application.TimeNow >= _serversUntil)
            {
                await RefreshServers();
            }
            Run(_negotiation.Offered(offer));
        }

        private async Task RefreshServers()
        {
            try
            {
                IceServersResult told = await _application.Connection.ActAsync(
                    Methods.SignalingIceServers, new NoParams(), CancellationToken.None);
                _servers = told.IceServers;
                // Half of their life: a peer that is opened then still has the other half.
                _serversUntil = _application.TimeNow + told.Ttl * 500;
            }
            catch (Exception)
            {
                // Within one network no server is needed; without a path the engine ends the peer, and says so.
            }
        }

        private void ConnectionEnded(string reason, bool forGood)
        {
            _serversUntil = long.MinValue;
            Run(_negotiation.EndedAll(reason));
        }

        private void Run(IEnumerable<Effect> effects)
        {
            foreach (Effect effect in effects)
            {
                switch (effect.Kind)
                {
                    case EffectKind.SendAnswer:
                        _application.Connection.Post(Methods.SignalingAnswer, effect.Answer);
                        break;
                    case EffectKind.SendCandidate:
                        _application.Connection.Post(Methods.SignalingCandidate, effect.Candidate);
                        break;
                    default:
                        PostToCallbacks(effect, _servers);
                        break;
                }
            }
        }

        /// <summary>Lets a peer act where callbacks come. A program that sleeps gets no more candidates and peers.</summary>
        private void PostToCallbacks(Effect effect, IReadOnlyList<IceServer> servers)
        {
            bool isFull = Volatile.Read(ref _waiting) >= MostWaiting;
            if (isFull && effect.Kind == EffectKind.Open)
            {
                EndPeer(effect.PeerId, "the application does not run its callbacks");
                return;
            }
            if (isFull && effect.Kind == EffectKind.AddCandidate)
            {
                return;
            }
            Interlocked.Increment(ref _waiting);
            _client.CallbackContext.Post(
                _ =>
                {
                    Interlocked.Decrement(ref _waiting);
                    RunInCallbacks(effect, servers);
                },
                null);
        }

        private void RunInCallbacks(Effect effect, IReadOnlyList<IceServer> servers)
        {
            IMediaPeer peer;
            lock (_peers)
            {
                if (_isDisposed)
                {
                    return;
                }
                _peers.TryGetValue(effect.PeerId, out peer);
            }
            try
            {
                if (effect.Kind == EffectKind.Open)
                {
                    Keep(effect.PeerId, _open(RequestFor(effect, servers)));
                }
                else if (peer != null && effect.Kind == EffectKind.Apply)
                {
                    AnswerAsync(peer, effect.Offer).LetRun();
                }
                else if (peer != null && effect.Kind == EffectKind.AddCandidate)
                {
                    peer.AddCandidate(effect.Candidate);
                }
                else if (peer != null)
                {
                    lock (_peers)
                    {
                        _peers.Remove(effect.PeerId);
                    }
                    Close(peer);
                }
            }
            catch (Exception error)
            {
                _client.HandlerFailed(error);
                EndPeer(effect.PeerId, "the offer was refused here");
            }
        }

        private void Keep(string peerId, IMediaPeer opened)
        {
            lock (_peers)
            {
                if (!_isDisposed)
                {
                    _peers[peerId] = opened;
                    return;
                }
            }
            Close(opened);
        }

        private void Close(IMediaPeer peer)
        {
            try
            {
                peer.Dispose();
            }
            catch (Exception error)
            {
                _client.HandlerFailed(error);
            }
        }

        private MediaPeerRequest RequestFor(Effect effect, IReadOnlyList<IceServer> servers)
        {
            string peerId = effect.PeerId;
            return new MediaPeerRequest(
                peerId,
                effect.Offer.Replaces,
                servers,
                candidate => _application.Strand.Post(() => Run(_negotiation.Gathered(peerId, candidate))),
                () => _application.Strand.Post(() => RestartAsync(peerId).LetRun()));
        }

        private async Task AnswerAsync(IMediaPeer peer, Offer offer)
        {
            try
            {
                string sdp = await peer.AnswerAsync(offer);
                _application.Strand.Post(() => Run(_negotiation.Answered(offer.PeerId, offer.Generation, sdp)));
            }
            catch (Exception error)
            {
                // Half an answer cannot be taken back: the engine ends a peer that is not answered, this side does so now.
                _client.HandlerFailed(error);
                EndPeer(offer.PeerId, "the offer was refused here");
            }
        }

        private void EndPeer(string peerId, string reason)
        {
            _application.Strand.Post(() => Run(_negotiation.Ended(peerId, reason)));
        }

        private async Task RestartAsync(string peerId)
        {
            try
            {
                _serversUntil = long.MinValue;
                await _application.Connection.ActAsync(
                    Methods.SignalingRestart, new Restart { PeerId = peerId }, CancellationToken.None);
            }
            catch (RoISException error) when (!(error is OutOfResourcesException))
            {
                // The engine does not know the peer any more: only a new connection of its streams can help.
                Run(_negotiation.Ended(peerId, error.Message));
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
