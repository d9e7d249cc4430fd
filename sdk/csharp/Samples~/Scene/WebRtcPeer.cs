using System;
using System.Collections;
using System.Collections.Generic;
using System.Linq;
using System.Threading.Tasks;
using OpenRoIS.Media;
using Unity.WebRTC;
using UnityEngine;

namespace OpenRoIS.Samples
{
    /// <summary>A peer connection of Unity's WebRTC package (com.unity.webrtc 3): shows pictures, and plays sound.</summary>
    public sealed class WebRtcPeer : IMediaPeer
    {
        private readonly RTCPeerConnection _connection;
        private readonly MonoBehaviour _host;
        private readonly Action<Texture> _show;
        private AudioSource _sound;

        /// <param name="request">the peer that an engine has offered</param>
        /// <param name="host">runs coroutines; sound is played at its object</param>
        /// <param name="show">takes the texture of pictures, when it is there or is another one</param>
        public WebRtcPeer(MediaPeerRequest request, MonoBehaviour host, Action<Texture> show)
        {
            _host = host;
            _show = show;
            var configuration = new RTCConfiguration { iceServers = request.IceServers.Select(InUnity).ToArray() };
            _connection = new RTCPeerConnection(ref configuration);
            _connection.OnIceCandidate = found => request.CandidateFound(new Candidate
            {
                CandidateValue = found.Candidate,
                SdpMid = found.SdpMid,
                SdpMLineIndex = found.SdpMLineIndex
            });
            _connection.OnConnectionStateChange = state =>
            {
                if (state == RTCPeerConnectionState.Failed)
                {
                    request.Failed();
                }
            };
            _connection.OnTrack = received => Play(received.Track);
        }

        public Task<string> AnswerAsync(Offer offer)
        {
            var answer = new TaskCompletionSource<string>();
            _host.StartCoroutine(Answer(offer, answer));
            return answer.Task;
        }

        public void AddCandidate(Candidate candidate)
        {
            if (string.IsNullOrEmpty(candidate.CandidateValue))
            {
                return;
            }
            try
            {
                _connection.AddIceCandidate(new RTCIceCandidate(new RTCIceCandidateInit
                {
                    candidate = candidate.CandidateValue,
                    sdpMid = candidate.SdpMid,
                    sdpMLineIndex = candidate.SdpMLineIndex
                }));
            }
            catch (ArgumentException)
            {
                // One that the library does not know is passed over, as in ICE.
            }
        }

        public void Dispose()
        {
            _connection.Close();
            _connection.Dispose();
            if (_sound != null)
            {
                UnityEngine.Object.Destroy(_sound);
            }
        }

        private IEnumerator Answer(Offer offer, TaskCompletionSource<string> answer)
        {
            var remote = new RTCSessionDescription { type = RTCSdpType.Offer, sdp = offer.Sdp };
            RTCSetSessionDescriptionAsyncOperation offered = _connection.SetRemoteDescription(ref remote);
            yield return offered;
            if (Failed(offered.IsError, offered.Error, answer))
            {
                yield break;
            }
            // A game engine that offers by itself offers all that it has: what was not connected is not taken.
            var carried = new HashSet<string>(offer.Streams.Select(section => section.Mid));
            foreach (RTCRtpTransceiver transceiver in _connection.GetTransceivers())
            {
                transceiver.Direction = carried.Contains(transceiver.Mid)
                    ? RTCRtpTransceiverDirection.RecvOnly
                    : RTCRtpTransceiverDirection.Inactive;
            }
            RTCSessionDescriptionAsyncOperation created = _connection.CreateAnswer();
            yield return created;
            if (Failed(created.IsError, created.Error, answer))
            {
                yield break;
            }
            RTCSessionDescription local = created.Desc;
            RTCSetSessionDescriptionAsyncOperation applied = _connection.SetLocalDescription(ref local);
            yield return applied;
            if (!Failed(applied.IsError, applied.Error, answer))
            {
                answer.TrySetResult(local.sdp);
            }
        }

        private static bool Failed(bool failed, RTCError error, TaskCompletionSource<string> answer)
        {
            if (failed)
            {
                answer.TrySetException(new InvalidOperationException("WebRTC: " + error.message));
            }
            return failed;
        }

        private void Play(MediaStreamTrack track)
        {
            var video = track as VideoStreamTrack;
            var audio = track as AudioStreamTrack;
            if (video != null)
            {
                video.OnVideoReceived += picture => _show(picture);
            }
            else if (audio != null)
            {
                _sound = _sound ?? _host.gameObject.AddComponent<AudioSource>();
                _sound.SetTrack(audio);
                _sound.loop = true;
                _sound.Play();
            }
        }

        private static RTCIceServer InUnity(IceServer server)
        {
            return new RTCIceServer
            {
                urls = server.Urls.ToArray(),
                username = server.Username,
                credential = server.Credential
            };
        }
    }
}
