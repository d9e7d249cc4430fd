// The few types of Unity that the package uses, as far as it uses them: enough to compile and to drive its components
// without Unity. What Unity itself does is not tried here.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using Unity.Collections;

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

    [AttributeUsage(AttributeTargets.Field)]
    public class HeaderAttribute : Attribute
    {
        public HeaderAttribute(string header)
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
        public static void Destroy(Object gone)
        {
        }
    }

    public class Component : Object
    {
        private readonly Transform _transform;

        public Component()
        {
            _transform = this as Transform ?? new Transform();
        }

        public Transform transform
        {
            get { return _transform; }
        }
    }

    public class Behaviour : Component
    {
        public bool enabled { get; set; } = true;
    }

    public class Coroutine
    {
    }

    public class YieldInstruction
    {
    }

    public sealed class WaitForEndOfFrame : YieldInstruction
    {
    }

    public sealed class WaitForSeconds : YieldInstruction
    {
        public WaitForSeconds(float seconds)
        {
        }
    }

    public class Animator : Behaviour
    {
        public void Play(string stateName)
        {
        }
    }

    public class MonoBehaviour : Behaviour
    {
        public static readonly List<IEnumerator> Coroutines = new List<IEnumerator>();

        public void StopAllCoroutines()
        {
            Coroutines.Clear();
        }

        public Coroutine StartCoroutine(IEnumerator routine)
        {
            Coroutines.Add(routine);
            return new Coroutine();
        }
    }

    public class Transform : Component
    {
        public Vector3 position { get; set; }

        public Quaternion rotation { get; set; }
    }

    public struct Vector3
    {
        public float x;
        public float y;
        public float z;

        public Vector3(float x, float y, float z)
        {
            this.x = x;
            this.y = y;
            this.z = z;
        }

        public static float Distance(Vector3 a, Vector3 b)
        {
            float x = a.x - b.x;
            float y = a.y - b.y;
            float z = a.z - b.z;
            return (float)Math.Sqrt(x * x + y * y + z * z);
        }
    }

    public struct Quaternion
    {
        public Vector3 eulerAngles { get; set; }

        public static Quaternion Euler(float x, float y, float z)
        {
            return new Quaternion { eulerAngles = new Vector3(x, y, z) };
        }
    }

    public class Texture : Object
    {
    }

    public enum RenderTextureFormat
    {
        ARGB32
    }

    public enum RenderTextureReadWrite
    {
        sRGB
    }

    public enum TextureFormat
    {
        BGRA32
    }

    public class RenderTexture : Texture
    {
        public readonly int width;
        public readonly int height;

        public RenderTexture(
            int width, int height, int depth, RenderTextureFormat format, RenderTextureReadWrite readWrite)
        {
            this.width = width;
            this.height = height;
        }

        public void Release()
        {
        }
    }

    public class Camera : Behaviour
    {
        public RenderTexture targetTexture { get; set; }
    }

    public class Mesh : Object
    {
        public int GetBlendShapeIndex(string name)
        {
            return name == "viseme_aa" ? 0 : -1;
        }
    }

    public class SkinnedMeshRenderer : Component
    {
        public float Weight;

        public Mesh sharedMesh { get; } = new Mesh();

        public void SetBlendShapeWeight(int index, float value)
        {
            Weight = value;
        }
    }

    public static class SystemInfo
    {
        public static bool supportsAsyncGPUReadback
        {
            get { return true; }
        }
    }

    public static class AudioSettings
    {
        public static int outputSampleRate
        {
            get { return 44100; }
        }
    }

    public static class Time
    {
        public static float deltaTime { get; set; }
    }

    public static class Debug
    {
        public static void LogWarning(object message)
        {
            Console.WriteLine("warning: " + message);
        }

        public static void LogError(object message)
        {
            Console.WriteLine("error: " + message);
        }
    }

    public static class Application
    {
        public static bool HasQuit;

        public static bool runInBackground { get; set; }

        public static string productName
        {
            get { return "stub"; }
        }

        public static string unityVersion
        {
            get { return "none"; }
        }

        public static void Quit()
        {
            HasQuit = true;
        }
    }
}

namespace UnityEngine.Rendering
{
    public struct AsyncGPUReadbackRequest
    {
        internal byte[] Pixels;

        public bool hasError
        {
            get { return Pixels == null; }
        }

        public NativeArray<T> GetData<T>(int layer = 0) where T : struct
        {
            return new NativeArray<T>(Pixels);
        }
    }

    public static class AsyncGPUReadback
    {
        /// <summary>The pixels of the next picture; null for a read-back that fails.</summary>
        public static byte[] Pixels;

        private static readonly Queue<Action<AsyncGPUReadbackRequest>> Asked =
            new Queue<Action<AsyncGPUReadbackRequest>>();

        public static AsyncGPUReadbackRequest Request(
            Texture src, int mipIndex, TextureFormat dstFormat, Action<AsyncGPUReadbackRequest> callback)
        {
            Asked.Enqueue(callback);
            return new AsyncGPUReadbackRequest();
        }

        /// <summary>Two frames later, as from a graphics card.</summary>
        public static void Answer()
        {
            if (Asked.Count > 2)
            {
                Asked.Dequeue()(new AsyncGPUReadbackRequest { Pixels = Pixels });
            }
        }
    }
}

namespace Unity.Collections
{
    public struct NativeArray<T> where T : struct
    {
        internal readonly byte[] Bytes;

        internal NativeArray(byte[] bytes)
        {
            Bytes = bytes;
        }

        public int Length
        {
            get { return Bytes.Length; }
        }
    }
}

namespace Unity.Collections.LowLevel.Unsafe
{
    public static unsafe class NativeArrayUnsafeUtility
    {
        private static GCHandle _pinned;

        public static void* GetUnsafeReadOnlyPtr<T>(NativeArray<T> nativeArray) where T : struct
        {
            if (_pinned.IsAllocated)
            {
                _pinned.Free();
            }
            _pinned = GCHandle.Alloc(nativeArray.Bytes, GCHandleType.Pinned);
            return (void*)_pinned.AddrOfPinnedObject();
        }
    }
}
