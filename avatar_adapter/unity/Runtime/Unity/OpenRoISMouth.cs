using UnityEngine;

namespace OpenRoIS.Link.Unity
{
    /// <summary>Moves the blend shapes of a face while the avatar speaks, or the operator through it.</summary>
    [AddComponentMenu("OpenRoIS/OpenRoIS Mouth")]
    public sealed class OpenRoISMouth : MonoBehaviour
    {
        private const float Whole = 100f;

        public OpenRoISLink Link;
        public SkinnedMeshRenderer Face;

        [Tooltip("What stands before the names of the visemes in those of the blend shapes, as viseme_aa")]
        public string Prefix = "viseme_";

        private readonly Mouth _mouth = new Mouth();
        private readonly float[] _weights = new float[Visemes.Names.Count];
        private int[] _shapes;

        /// <summary>The weight of a viseme now, from 0 to 1; by its place in Visemes.Names.</summary>
        public float WeightOf(int viseme)
        {
            return _weights[viseme];
        }

        private void OnEnable()
        {
            Link.Speak += _mouth.Take;
            Link.Heard += OnHeard;
            Link.Silence += OnSilence;
            Link.Disconnected += OnDisconnected;
        }

        private void OnDisable()
        {
            Link.Speak -= _mouth.Take;
            Link.Heard -= OnHeard;
            Link.Silence -= OnSilence;
            Link.Disconnected -= OnDisconnected;
        }

        private void Start()
        {
            _shapes = new int[_weights.Length];
            for (int viseme = 0; viseme < _shapes.Length; viseme++)
            {
                // -1 where the face has none of that name.
                string name = Prefix + Visemes.Names[viseme];
                _shapes[viseme] = Face == null ? -1 : Face.sharedMesh.GetBlendShapeIndex(name);
            }
        }

        private void LateUpdate()
        {
            _mouth.Weigh(Link.Now, _weights);
            for (int viseme = 0; viseme < _shapes.Length; viseme++)
            {
                if (_shapes[viseme] >= 0)
                {
                    Face.SetBlendShapeWeight(_shapes[viseme], Whole * _weights[viseme]);
                }
            }
        }

        private void OnHeard(Heard heard)
        {
            _mouth.Take(heard, Link.Now);
        }

        private void OnSilence()
        {
            _mouth.Silence(Link.Now);
        }

        private void OnDisconnected(string reason)
        {
            _mouth.Silence(Link.Now);
        }
    }
}
