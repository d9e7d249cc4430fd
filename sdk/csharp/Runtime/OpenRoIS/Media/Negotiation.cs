// Copyright the OpenRoIS authors. Apache-2.0.
using System.Collections.Generic;

namespace OpenRoIS.Media
{
    /// <summary>What is to be done next.</summary>
    internal enum EffectKind
    {
        /// <summary>Open the peer connection <see cref="Effect.PeerId"/>.</summary>
        Open,

        /// <summary>Apply <see cref="Effect.Offer"/>, and say <see cref="Negotiation.Answered"/>.</summary>
        Apply,

        SendAnswer,
        AddCandidate,
        SendCandidate,
        Close
    }

    /// <summary>One thing to be done.</summary>
    internal sealed class Effect
    {
        internal EffectKind Kind { get; set; }

        internal string PeerId { get; set; }

        internal Offer Offer { get; set; }

        internal Answer Answer { get; set; }

        internal Candidate Candidate { get; set; }

        internal string Reason { get; set; }
    }

    /// <summary>
    /// The answerer's half of the negotiation, without input or output: messages and outcomes in, effects out. The engine
    /// offers, this side answers. A <c>peer_id</c> names one peer connection for its whole life; <c>generation</c> counts its
    /// offers, and one that is not newer than the last is dropped. Offers of one peer are applied one at a time; candidates
    /// wait until there is a description to which they belong.
    /// </summary>
    internal sealed class Negotiation
    {
        /// <summary>Peer connections at one time: one in use, one that replaces it, and room for a burst of restarts.</summary>
        internal const int MostPeers = 6;

        /// <summary>Candidates of one peer that wait, in each direction.</summary>
        internal const int MostWaiting = 64;

        /// <summary>Ended peers that are remembered, so that late messages are ignored.</summary>
        private const int MostEnded = 64;

        private readonly Dictionary<string, Peer> _peers = new Dictionary<string, Peer>();
        private readonly HashSet<string> _ended = new HashSet<string>();
        private readonly Queue<string> _endedOrder = new Queue<string>();

        internal IEnumerable<Effect> Offered(Offer offer)
        {
            Peer peer;
            if (_ended.Contains(offer.PeerId))
            {
                yield break;
            }
            if (!_peers.TryGetValue(offer.PeerId, out peer))
            {
                if (_peers.Count >= MostPeers)
                {
                    yield break;
                }
                _peers[offer.PeerId] = new Peer { Generation = offer.Generation, Applying = offer.Generation };
                yield return new Effect { Kind = EffectKind.Open, PeerId = offer.PeerId, Offer = offer };
                yield return new Effect { Kind = EffectKind.Apply, PeerId = offer.PeerId, Offer = offer };
                yield break;
            }
            if (offer.Generation <= peer.Generation)
            {
                yield break;
            }
            peer.Generation = offer.Generation;
            if (peer.Applying != null)
            {
                peer.Next = offer;
                yield break;
            }
            peer.Applying = offer.Generation;
            yield return new Effect { Kind = EffectKind.Apply, PeerId = offer.PeerId, Offer = offer };
        }

        /// <summary>Takes the answer to the offer of a generation, once applied.</summary>
        internal IEnumerable<Effect> Answered(string peerId, int generation, string sdp)
        {
            Peer peer;
            if (!_peers.TryGetValue(peerId, out peer) || peer.Applying != generation)
            {
                yield break;
            }
            peer.Applying = null;
            peer.HasAnswered = true;
            var answer = new Answer { PeerId = peerId, Generation = generation, Sdp = sdp };
            yield return new Effect { Kind = EffectKind.SendAnswer, PeerId = peerId, Answer = answer };
            while (peer.Local.Count > 0)
            {
                yield return Sent(peerId, generation, peer.Local.Dequeue());
            }
            while (peer.Remote.Count > 0)
            {
                yield return Added(peerId, peer.Remote.Dequeue());
            }
            if (peer.Next != null)
            {
                Offer next = peer.Next;
                peer.Next = null;
                peer.Applying = next.Generation;
                yield return new Effect { Kind = EffectKind.Apply, PeerId = peerId, Offer = next };
            }
        }

        /// <summary>Takes a candidate of the engine. Those of earlier generations stay valid: all share one ICE session.</summary>
        internal IEnumerable<Effect> Received(Candidate candidate)
        {
            Peer peer;
            if (!_peers.TryGetValue(candidate.PeerId, out peer) || candidate.Generation > peer.Generation)
            {
                yield break;
            }
            if (peer.IsSettled)
            {
                yield return Added(candidate.PeerId, candidate);
            }
            else if (peer.Remote.Count < MostWaiting)
            {
                peer.Remote.Enqueue(candidate);
            }
        }

        /// <summary>Takes a candidate that this side gathered; its generation is that of the description.</summary>
        internal IEnumerable<Effect> Gathered(string peerId, Candidate candidate)
        {
            Peer peer;
            if (!_peers.TryGetValue(peerId, out peer))
            {
                yield break;
            }
            if (peer.IsSettled)
            {
                yield return Sent(peerId, peer.Generation, candidate);
            }
            else if (peer.Local.Count < MostWaiting)
            {
                peer.Local.Enqueue(candidate);
            }
        }

        /// <summary>Ends a peer, by the engine's bye or this side's decision.</summary>
        internal IEnumerable<Effect> Ended(string peerId, string reason)
        {
            Remember(peerId);
            if (_peers.Remove(peerId))
            {
                yield return new Effect { Kind = EffectKind.Close, PeerId = peerId, Reason = reason };
            }
        }

        /// <summary>Ends all peers, since the session is gone.</summary>
        internal IEnumerable<Effect> EndedAll(string reason)
        {
            foreach (string peerId in new List<string>(_peers.Keys))
            {
                foreach (Effect effect in Ended(peerId, reason))
                {
                    yield return effect;
                }
            }
        }

        private void Remember(string peerId)
        {
            if (_ended.Add(peerId))
            {
                _endedOrder.Enqueue(peerId);
                if (_endedOrder.Count > MostEnded)
                {
                    _ended.Remove(_endedOrder.Dequeue());
                }
            }
        }

        private static Effect Sent(string peerId, int generation, Candidate candidate)
        {
            candidate.PeerId = peerId;
            candidate.Generation = generation;
            return new Effect { Kind = EffectKind.SendCandidate, PeerId = peerId, Candidate = candidate };
        }

        private static Effect Added(string peerId, Candidate candidate)
        {
            return new Effect { Kind = EffectKind.AddCandidate, PeerId = peerId, Candidate = candidate };
        }

        private sealed class Peer
        {
            internal readonly Queue<Candidate> Remote = new Queue<Candidate>();
            internal readonly Queue<Candidate> Local = new Queue<Candidate>();
            internal int Generation;

            /// <summary>The generation whose answer is being made; null when none is.</summary>
            internal int? Applying;
            internal bool HasAnswered;
            internal Offer Next;

            internal bool IsSettled
            {
                get { return HasAnswered && Applying == null; }
            }
        }
    }
}
