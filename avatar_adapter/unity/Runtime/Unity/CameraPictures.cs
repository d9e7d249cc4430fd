using System;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;
using UnityEngine.Rendering;

namespace OpenRoIS.Link.Unity
{
    /// <summary>The pictures of a camera, read back from the graphics card without waiting for it.</summary>
    internal sealed class CameraPictures
    {
        /// <summary>More that are on their way would be late, and cost memory.</summary>
        private const int MaxReadbacks = 3;
        private const int DepthBits = 24;

        private readonly Camera _source;
        private readonly RenderTexture _target;
        private readonly Picture _shape;
        private readonly double _period;
        private readonly LinkClient _client;
        private double _due;
        private int _readbacks;

        internal CameraPictures(Camera source, Picture shape, double picturesPerSecond, LinkClient client)
        {
            _source = source;
            _shape = shape;
            _period = 1.0 / picturesPerSecond;
            _client = client;
            _target = new RenderTexture(
                shape.Width, shape.Height, DepthBits, RenderTextureFormat.ARGB32, RenderTextureReadWrite.sRGB);
            source.targetTexture = _target;
        }

        /// <summary>Let the camera draw from now on, or not.</summary>
        internal void Draw(bool on)
        {
            if (_source.enabled != on)
            {
                _source.enabled = on;
            }
        }

        /// <summary>Take the picture of this frame if one is due; call it when the frame is drawn.</summary>
        /// <param name="frameNs">The moment for which the scene was moved.</param>
        internal void Take(long frameNs)
        {
            double now = frameNs / 1e9;
            // A frame that comes a little early is better than none until the next one. A due moment that is far
            // off is of a clock that was set anew since.
            bool early = now < _due - _period / 4 && now > _due - 2 * _period;
            if (early || _readbacks >= MaxReadbacks)
            {
                return;
            }
            _due = Math.Abs(now - _due) < 2 * _period ? _due + _period : now + _period;
            _readbacks++;
            AsyncGPUReadback.Request(_target, 0, TextureFormat.BGRA32, request => Send(request, frameNs));
        }

        internal void Release()
        {
            if (_source != null)
            {
                _source.targetTexture = null;
            }
            _target.Release();
            UnityEngine.Object.Destroy(_target);
        }

        private unsafe void Send(AsyncGPUReadbackRequest request, long frameNs)
        {
            _readbacks--;
            if (!request.hasError)
            {
                NativeArray<byte> pixels = request.GetData<byte>();
                IntPtr at = (IntPtr)NativeArrayUnsafeUtility.GetUnsafeReadOnlyPtr(pixels);
                _client.SendPicture(at, pixels.Length, _shape, frameNs);
            }
        }
    }
}
