// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Threading.Tasks;

namespace OpenRoIS.Media
{
    /// <summary>
    /// The answering side of one WebRTC peer connection: what a program's WebRTC library does. All members are called in the
    /// context of <see cref="ClientOptions.Callbacks"/>, one at a time, but for the end: <see cref="MediaSession.Dispose"/>
    /// disposes of it where that is called. To dispose of it closes the connection.
    /// </summary>
    public interface IMediaPeer : IDisposable
    {
        /// <summary>
        /// Applies an offer, and returns the SDP of the answer. The next offer of this peer comes once that is done. Sections
        /// that are not in <see cref="Offer.Streams"/> are to be answered <c>inactive</c>; the direction of those that are is
        /// that of the application.
        /// </summary>
        /// <exception cref="Exception">the library refuses it: the peer is ended</exception>
        Task<string> AnswerAsync(Offer offer);

        /// <summary>
        /// Adds a candidate of the engine; a <see cref="Candidate.CandidateValue"/> of null says that there are no more. One
        /// that cannot be used is passed over, as in ICE.
        /// </summary>
        void AddCandidate(Candidate candidate);
    }

    /// <summary>A peer connection that an engine has offered.</summary>
    public sealed class MediaPeerRequest
    {
        internal MediaPeerRequest(
            string peerId, string replaces, IReadOnlyList<IceServer> iceServers,
            Action<Candidate> candidateFound, Action failed)
        {
            PeerId = peerId;
            Replaces = replaces;
            IceServers = iceServers;
            CandidateFound = candidateFound;
            Failed = failed;
        }

        public string PeerId { get; private set; }

        /// <summary>
        /// The peer in whose place it comes, or null. That one goes on until the engine ends it, when this one plays: show
        /// this one's pictures from the first that arrives.
        /// </summary>
        public string Replaces { get; private set; }

        /// <summary>STUN and TURN servers; empty where none are needed.</summary>
        public IReadOnlyList<IceServer> IceServers { get; private set; }

        /// <summary>
        /// To be called with each candidate that this side gathers; its <see cref="Candidate.CandidateValue"/>,
        /// <see cref="Candidate.SdpMid"/> and <see cref="Candidate.SdpMLineIndex"/> count. From any thread.
        /// </summary>
        public Action<Candidate> CandidateFound { get; private set; }

        /// <summary>To be called when the path is lost for good: another peer is asked for. From any thread.</summary>
        public Action Failed { get; private set; }
    }
}
