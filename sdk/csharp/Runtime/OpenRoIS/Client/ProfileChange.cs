// Copyright the OpenRoIS authors. Apache-2.0.
using System.Collections.Generic;
using System.Linq;

namespace OpenRoIS
{
    /// <summary>Engines behind the gateway came, went, or are others now.</summary>
    public sealed class ProfileChange
    {
        private readonly HashSet<string> _engineIds;

        internal ProfileChange()
            : this(Enumerable.Empty<string>())
        {
        }

        internal ProfileChange(IEnumerable<string> engineIds)
        {
            _engineIds = new HashSet<string>(engineIds);
        }

        /// <summary>Which; empty where the gateway does not say, or there are too many: any may have changed.</summary>
        public IReadOnlyCollection<string> EngineIds
        {
            get { return _engineIds.ToList(); }
        }

        /// <summary>Whether it may concern what has a name that begins with an engine's id.</summary>
        internal bool MayConcern(string name)
        {
            return _engineIds.Count == 0 || _engineIds.Contains(name.Split('/')[0]);
        }

        /// <summary>This change and another one.</summary>
        internal ProfileChange With(ProfileChange other)
        {
            bool named = _engineIds.Count > 0 && other._engineIds.Count > 0;
            return named ? new ProfileChange(_engineIds.Concat(other._engineIds)) : new ProfileChange();
        }
    }
}
