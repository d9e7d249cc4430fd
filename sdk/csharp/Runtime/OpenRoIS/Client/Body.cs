// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>What an application needs of a body.</summary>
    public sealed class BodyRequest
    {
        /// <param name="required">component types that the body must have, such as <c>Navigation.Type</c></param>
        public BodyRequest(params ComponentType[] required)
        {
            Required = required;
        }

        public IReadOnlyList<ComponentType> Required { get; private set; }

        /// <summary>Types that it should have; it is reserved without those that are taken, or not there.</summary>
        public IReadOnlyList<ComponentType> Optional { get; set; } = new ComponentType[0];

        /// <summary>Of components: <c>Condition.ComponentRefLike("avatar/%")</c>.</summary>
        public string Condition { get; set; } = "";

        /// <summary>How long it is tried again; zero for once. An attempt that has begun is finished.</summary>
        public TimeSpan Wait { get; set; } = TimeSpan.FromSeconds(10);

        internal IEnumerable<ComponentType> All
        {
            get { return Required.Concat(Optional); }
        }

        public override string ToString()
        {
            return string.Join(" and ", Required.Select(type => type.Code));
        }

        internal void Check()
        {
            if (Required.Count == 0)
            {
                throw new ArgumentException(
                    "name at least one component type that the body must have: new BodyRequest(Navigation.Type)");
            }
            string twice = All.GroupBy(type => type.Urn).Where(group => group.Count() > 1)
                .Select(group => ComponentType.CodeOf(group.Key)).FirstOrDefault();
            if (twice != null)
            {
                throw new ArgumentException(
                    twice + " is named twice, and a body is reserved with one component of a type");
            }
        }
    }

    /// <summary>
    /// A reserved body: components of one engine that this application holds until it is disposed of, or lost.
    /// </summary>
    public sealed class Body : IDisposable
    {
        private readonly Reservation _reservation;
        private readonly IReadOnlyDictionary<string, ComponentProxy> _parts;
        private readonly Bodies _bodies;

        internal Body(Reservation reservation, IReadOnlyDictionary<string, ComponentProxy> parts, Bodies bodies)
        {
            _reservation = reservation;
            _parts = parts;
            _bodies = bodies;
        }

        /// <summary>The engine that the body is; <see cref="Control.StopAllAsync"/> takes it.</summary>
        public string EngineId
        {
            get { return _reservation.EngineId; }
        }

        /// <summary>Why the body is lost, as the operation that found out would have thrown it; null while it is held.</summary>
        public Exception Error
        {
            get { return _reservation.Error; }
        }

        /// <summary>Returns its component of a type. It stays what it was when the body is lost.</summary>
        /// <exception cref="KeyNotFoundException">the body was reserved without one</exception>
        public T Part<T>(ComponentType<T> type)
            where T : ComponentProxy
        {
            ComponentProxy part;
            if (!_parts.TryGetValue(type.Urn, out part))
            {
                throw new KeyNotFoundException(
                    EngineId + " is reserved without " + type + ": there is "
                    + string.Join(", ", _parts.Keys.Select(ComponentType.CodeOf)));
            }
            return (T)part;
        }

        /// <summary>Returns its component of a type that is bound now, or null: for optional ones.</summary>
        public T Find<T>(ComponentType<T> type)
            where T : ComponentProxy
        {
            ComponentProxy part;
            bool isBound = _reservation.Bound.ContainsKey(type.Urn);
            return isBound && _parts.TryGetValue(type.Urn, out part) ? (T)part : null;
        }

        /// <summary>Releases all components, and returns once the gateway has done that. Idempotent; throws nothing.</summary>
        public Task ReleaseAsync()
        {
            return _bodies.ReleaseAsync(_reservation);
        }

        /// <summary>Releases all components without waiting for the gateway: what is asked next comes after it.</summary>
        public void Dispose()
        {
            _bodies.ReleaseAsync(_reservation).LetRun();
        }
    }

    /// <summary>Components of one engine that are reserved together. Written in the client's strand.</summary>
    internal sealed class Reservation
    {
        internal readonly string EngineId;

        /// <summary>The URNs of the types that may be missing.</summary>
        internal readonly HashSet<string> Optional;

        internal Reservation(string engineId, IEnumerable<string> optional)
        {
            EngineId = engineId;
            Optional = new HashSet<string>(optional);
            Bound = new Dictionary<string, string>();
        }

        /// <summary>The references of the components that are bound, by the URNs of their types. Never changed in place.</summary>
        internal IReadOnlyDictionary<string, string> Bound { get; private set; }

        /// <summary>Whether the application has the body.</summary>
        internal bool Complete { get; set; }

        /// <summary>Why it is lost; null while it is not.</summary>
        internal Exception Error { get; set; }

        internal void Add(string urn, string componentRef)
        {
            Bound = Bound.Concat(new[] { new KeyValuePair<string, string>(urn, componentRef) })
                .ToDictionary(each => each.Key, each => each.Value);
        }

        internal void Remove(string urn)
        {
            Bound = Bound.Where(each => each.Key != urn).ToDictionary(each => each.Key, each => each.Value);
        }

        /// <summary>Removes and returns all references.</summary>
        internal IReadOnlyList<string> TakeAll()
        {
            List<string> refs = Bound.Values.ToList();
            Bound = new Dictionary<string, string>();
            return refs;
        }

        internal void RequireHeld()
        {
            if (Error != null)
            {
                throw new OutOfResourcesException("a part of " + EngineId + " was lost again: " + Error.Message);
            }
        }
    }
}
