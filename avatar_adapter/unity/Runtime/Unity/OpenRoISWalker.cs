using System;
using UnityEngine;

namespace OpenRoIS.Link.Unity
{
    /// <summary>
    /// Sends this object about as Walk, Drive and Halt demand, on the floor it stands on, and tells where it is. The
    /// link's Walks has to be on. To keep a driven figure off what is in the way, set CanStand.
    /// </summary>
    [AddComponentMenu("OpenRoIS/OpenRoIS Walker")]
    public sealed class OpenRoISWalker : MonoBehaviour
    {
        public OpenRoISLink Link;

        private Walker _walker;

        /// <summary>Whether the figure can be at this x and z of the world; null for everywhere.</summary>
        public Func<float, float, bool> CanStand { get; set; }

        /// <summary>Metres a second over the floor, for the animation of its legs.</summary>
        public float Speed { get; private set; }

        private void Awake()
        {
            FloorPoint at = Coordinates.ToLink(transform.position.x, transform.position.z);
            double th = Coordinates.ToTh(transform.rotation.eulerAngles.y);
            _walker = new Walker(at.X, at.Y, th, Link.Reached, Link.Completed);
            _walker.CanStand = IsFree;
        }

        private void OnEnable()
        {
            Link.Walk += _walker.Take;
            Link.Drive += _walker.Take;
            Link.Halt += _walker.Halt;
            Link.Disconnected += OnDisconnected;
        }

        private void OnDisable()
        {
            _walker.Halt();
            Link.Walk -= _walker.Take;
            Link.Drive -= _walker.Take;
            Link.Halt -= _walker.Halt;
            Link.Disconnected -= OnDisconnected;
        }

        private void Update()
        {
            Vector3 before = transform.position;
            bool moves = _walker.IsMoving;
            _walker.Advance(Time.deltaTime);
            if (moves)
            {
                double x;
                double z;
                Coordinates.ToUnity(_walker.X, _walker.Y, out x, out z);
                transform.position = new Vector3((float)x, before.y, (float)z);
                transform.rotation = Quaternion.Euler(0f, (float)Coordinates.ToYaw(_walker.Th), 0f);
            }
            float way = Vector3.Distance(before, transform.position);
            Speed = Time.deltaTime > 0f ? way / Time.deltaTime : 0f;
            Link.Place(transform.position, transform.rotation);
        }

        private bool IsFree(double x, double y)
        {
            double unityX;
            double unityZ;
            Coordinates.ToUnity(x, y, out unityX, out unityZ);
            return CanStand == null || CanStand((float)unityX, (float)unityZ);
        }

        private void OnDisconnected(string reason)
        {
            _walker.Forget();
        }
    }
}
