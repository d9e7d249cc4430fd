// The few types of Unity, and of its WebRTC package, that the package and its sample use, as far as they use them: enough to
// compile them and to drive their components without Unity. What Unity itself does is not tried here.
using System;
using System.Collections;
using System.Collections.Generic;

namespace UnityEngine
{
    public class DefaultExecutionOrder : Attribute
    {
        public DefaultExecutionOrder(int order)
        {
        }
    }

    public sealed class AddComponentMenu : Attribute
    {
        public AddComponentMenu(string menuName)
        {
        }
    }

    public sealed class RequireComponent : Attribute
    {
        public RequireComponent(Type required)
        {
        }
    }

    [AttributeUsage(AttributeTargets.Field)]
    public class TooltipAttribute : Attribute
    {
        public TooltipAttribute(string tooltip)
        {
        }
    }

    public class Object
    {
        public static void Destroy(Object destroyed)
        {
        }
    }

    public class Component : Object
    {
        public GameObject gameObject { get; set; }

        public T GetComponent<T>() where T : Component
        {
            return gameObject.GetComponent<T>();
        }
    }

    public sealed class GameObject : Object
    {
        public readonly List<Component> Components = new List<Component>();

        public T AddComponent<T>() where T : Component, new()
        {
            var added = new T { gameObject = this };
            Components.Add(added);
            return added;
        }

        public T GetComponent<T>() where T : Component
        {
            return (T)Components.Find(each => each is T);
        }
    }

    public class Behaviour : Component
    {
    }

    public class Coroutine
    {
    }

    public class CustomYieldInstruction : IEnumerator
    {
        public object Current
        {
            get { return null; }
        }

        public bool MoveNext()
        {
            return false;
        }

        public void Reset()
        {
        }
    }

    public class MonoBehaviour : Behaviour
    {
        public static readonly List<IEnumerator> Coroutines = new List<IEnumerator>();

        public Coroutine StartCoroutine(IEnumerator routine)
        {
            Coroutines.Add(routine);
            return new Coroutine();
        }
    }

    public class Texture : Object
    {
    }

    public class Material : Object
    {
        public Texture mainTexture { get; set; }
    }

    public class Renderer : Component
    {
        public Material material { get; } = new Material();
    }

    public sealed class AudioSource : Behaviour
    {
        public bool loop { get; set; }

        public void Play()
        {
        }
    }

    public static class Time
    {
        public static double realtimeSinceStartupAsDouble
        {
            get { return System.Diagnostics.Stopwatch.GetTimestamp() / (double)System.Diagnostics.Stopwatch.Frequency; }
        }
    }

    public static class Debug
    {
        public static readonly List<string> Warnings = new List<string>();

        public static void Log(object message)
        {
            Console.WriteLine(message);
        }

        public static void LogWarning(object message)
        {
            Warnings.Add(message.ToString());
        }

        public static void LogException(Exception exception)
        {
            Console.Error.WriteLine(exception);
            Environment.Exit(2);
        }
    }
}

namespace Unity.WebRTC
{
    using UnityEngine;

    public enum RTCPeerConnectionState
    {
        Failed = 4
    }

    public enum RTCSdpType
    {
        Offer
    }

    public enum RTCRtpTransceiverDirection
    {
        RecvOnly = 2,
        Inactive = 3
    }

    public static class WebRTC
    {
        public static IEnumerator Update()
        {
            yield break;
        }
    }

    public struct RTCIceServer
    {
        public string credential;
        public string[] urls;
        public string username;
    }

    public struct RTCConfiguration
    {
        public RTCIceServer[] iceServers;
    }

    public struct RTCSessionDescription
    {
        public RTCSdpType type;
        public string sdp;
    }

    public struct RTCError
    {
        public string message;
    }

    public sealed class RTCIceCandidateInit
    {
        public string candidate;
        public string sdpMid;
        public int? sdpMLineIndex;
    }

    public sealed class RTCIceCandidate
    {
        public RTCIceCandidate(RTCIceCandidateInit candidateInfo)
        {
            if (!candidateInfo.candidate.StartsWith("candidate:"))
            {
                throw new ArgumentException("create candidate is failed");
            }
            Candidate = candidateInfo.candidate;
        }

        public string Candidate { get; private set; }

        public string SdpMid { get; private set; }

        public int? SdpMLineIndex { get; private set; }
    }

    public class MediaStreamTrack
    {
    }

    public delegate void OnVideoReceived(Texture renderer);

    public sealed class VideoStreamTrack : MediaStreamTrack
    {
        public event OnVideoReceived OnVideoReceived;

        public void Receive(Texture picture)
        {
            OnVideoReceived(picture);
        }
    }

    public sealed class AudioStreamTrack : MediaStreamTrack
    {
    }

    public static class AudioSourceExtension
    {
        public static void SetTrack(this AudioSource source, AudioStreamTrack track)
        {
        }
    }

    public sealed class RTCTrackEvent
    {
        public MediaStreamTrack Track { get; set; }
    }

    public sealed class RTCRtpTransceiver
    {
        public string Mid { get; set; }

        public RTCRtpTransceiverDirection Direction { get; set; }
    }

    public class RTCSessionDescriptionAsyncOperation : CustomYieldInstruction
    {
        public bool IsError { get; set; }

        public RTCError Error { get; set; }

        public RTCSessionDescription Desc { get; set; }
    }

    public class RTCSetSessionDescriptionAsyncOperation : CustomYieldInstruction
    {
        public bool IsError { get; set; }

        public RTCError Error { get; set; }
    }

    public sealed class RTCPeerConnection : IDisposable
    {
        public static readonly List<string> Said = new List<string>();

        public Action<RTCIceCandidate> OnIceCandidate;
        public Action<RTCPeerConnectionState> OnConnectionStateChange;
        public Action<RTCTrackEvent> OnTrack;

        public RTCPeerConnection(ref RTCConfiguration configuration)
        {
            Said.Add("open");
        }

        public RTCSetSessionDescriptionAsyncOperation SetRemoteDescription(ref RTCSessionDescription desc)
        {
            Said.Add("remote " + desc.sdp);
            return new RTCSetSessionDescriptionAsyncOperation();
        }

        public RTCSetSessionDescriptionAsyncOperation SetLocalDescription(ref RTCSessionDescription desc)
        {
            Said.Add("local " + desc.sdp);
            return new RTCSetSessionDescriptionAsyncOperation();
        }

        public RTCSessionDescriptionAsyncOperation CreateAnswer()
        {
            return new RTCSessionDescriptionAsyncOperation { Desc = new RTCSessionDescription { sdp = "v=0 answer" } };
        }

        public IEnumerable<RTCRtpTransceiver> GetTransceivers()
        {
            return new RTCRtpTransceiver[0];
        }

        public bool AddIceCandidate(RTCIceCandidate candidate)
        {
            Said.Add("candidate " + candidate.Candidate);
            return true;
        }

        public void Close()
        {
            Said.Add("close");
        }

        public void Dispose()
        {
        }
    }
}
