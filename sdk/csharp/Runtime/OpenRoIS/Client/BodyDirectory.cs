// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;

namespace OpenRoIS
{
    /// <summary>A component of a body.</summary>
    public sealed class BodyComponent
    {
        internal BodyComponent(string componentRef, string componentType, bool? free)
        {
            ComponentRef = componentRef;
            ComponentType = componentType;
            IsFree = free;
        }

        public string ComponentRef { get; private set; }

        /// <summary>The URN of its type.</summary>
        public string ComponentType { get; private set; }

        /// <summary>
        /// No application holds it; null where the gateway does not tell. What needs no reservation is free.
        /// </summary>
        public bool? IsFree { get; private set; }
    }

    /// <summary>A body: what it can do, and whether it is free.</summary>
    public sealed class BodyInfo
    {
        internal BodyInfo(string engineId, IReadOnlyList<BodyComponent> components)
        {
            EngineId = engineId;
            Components = components;
        }

        /// <summary>The engine, which leads the references of its components.</summary>
        public string EngineId { get; private set; }

        /// <summary>Sorted by reference.</summary>
        public IReadOnlyList<BodyComponent> Components { get; private set; }

        /// <summary>No application holds any part of it; null where the gateway does not tell.</summary>
        public bool? IsFree
        {
            get
            {
                if (Components.Any(component => component.IsFree == false))
                {
                    return false;
                }
                return Components.All(component => component.IsFree == true) ? true : (bool?)null;
            }
        }

        /// <summary>The references of its components of a type; empty where it has none.</summary>
        public IReadOnlyList<string> Refs(ComponentType type)
        {
            return Components.Where(each => each.ComponentType == type.Urn).Select(each => each.ComponentRef).ToList();
        }
    }

    /// <summary>A body as the profile or the directory describes it.</summary>
    internal sealed class BodyProfile
    {
        internal readonly string EngineId;

        /// <summary>References of components that applications reserve.</summary>
        internal readonly HashSet<string> Leased = new HashSet<string>();

        /// <summary>The URN of each component's type, by its reference, in sorted order.</summary>
        internal readonly SortedDictionary<string, string> Types = new SortedDictionary<string, string>(StringComparer.Ordinal);

        internal BodyProfile(string engineId)
        {
            EngineId = engineId;
        }

        /// <summary>What it can do, in one line.</summary>
        internal string Codes
        {
            get
            {
                return string.Join(", ", Types.Values.Select(OpenRoIS.ComponentType.CodeOf).Distinct()
                    .OrderBy(code => code, StringComparer.Ordinal));
            }
        }

        internal void Add(string componentRef, string urn, ComponentFunction? function)
        {
            Types[componentRef] = urn;
            if (function == ComponentFunction.Actuation)
            {
                Leased.Add(componentRef);
            }
        }

        internal bool Has(string urn)
        {
            return Types.ContainsValue(urn);
        }
    }

    /// <summary>
    /// Bodies in a gateway's profile or directory. RoIS 2.0 knows engines and components; a body is an engine that owns components: it
    /// lists some that no engine below it lists. What is reachable through it belongs to it, too. Behind the main engine
    /// stand all bodies, so that of those it has only what it owns itself: a body is never put together from two robots.
    /// </summary>
    internal static class BodyDirectory
    {
        /// <summary>The bodies in the order of their ids, inner engines before those around them.</summary>
        internal static List<BodyProfile> Read(ProfileResult answer)
        {
            var bodies = new List<BodyProfile>();
            if (answer.Profile == null)
            {
                return bodies;
            }
            foreach (HRIEngineProfile engine in Sorted(answer.Profile.SubProfiles))
            {
                Collect(engine, answer, bodies);
            }
            BodyProfile main = BodyOf(answer.Profile, OwnRefs(answer.Profile), answer);
            if (main.Types.Count > 0)
            {
                bodies.Add(main);
            }
            return bodies;
        }

        /// <summary>The same of a directory.</summary>
        internal static List<BodyProfile> Read(IReadOnlyList<EngineEntry> entries)
        {
            var bodies = new List<BodyProfile>();
            ILookup<string, EngineEntry> below =
                entries.OrderBy(entry => entry.EngineId, StringComparer.Ordinal).ToLookup(entry => entry.ParentId);
            foreach (EngineEntry main in below[""])
            {
                foreach (EngineEntry engine in below[main.EngineId])
                {
                    Collect(engine, below, bodies);
                }
                AddBody(main.EngineId, main.Components, bodies);
            }
            return bodies;
        }

        /// <summary>The URN of a component's type.</summary>
        internal static string UrnOf(HRIComponentProfile profile)
        {
            string code = profile.Identifier.Code;
            return code.StartsWith("urn:")
                ? code
                : "urn:x-rois:def:component:" + profile.Identifier.Authority + "::" + code;
        }

        private static void Collect(HRIEngineProfile engine, ProfileResult answer, List<BodyProfile> bodies)
        {
            foreach (HRIEngineProfile inner in Sorted(engine.SubProfiles))
            {
                Collect(inner, answer, bodies);
            }
            if (OwnRefs(engine).Any(answer.ComponentProfiles.ContainsKey))
            {
                bodies.Add(BodyOf(engine, Reachable(engine), answer));
            }
        }

        /// <summary>Adds the bodies of an engine and of those below it; returns the components of all of them.</summary>
        private static List<ComponentEntry> Collect(
            EngineEntry engine, ILookup<string, EngineEntry> below, List<BodyProfile> bodies)
        {
            List<ComponentEntry> inner =
                below[engine.EngineId].SelectMany(each => Collect(each, below, bodies)).ToList();
            List<ComponentEntry> all = engine.Components.Concat(inner).ToList();
            if (engine.Components.Count > 0)
            {
                AddBody(engine.EngineId, all, bodies);
            }
            return all;
        }

        private static void AddBody(string engineId, IReadOnlyList<ComponentEntry> components, List<BodyProfile> bodies)
        {
            if (components.Count == 0)
            {
                return;
            }
            var body = new BodyProfile(engineId);
            foreach (ComponentEntry component in components)
            {
                body.Add(component.ComponentRef, component.ComponentType, component.Function);
            }
            bodies.Add(body);
        }

        private static BodyProfile BodyOf(HRIEngineProfile engine, IEnumerable<string> refs, ProfileResult answer)
        {
            var body = new BodyProfile(engine.Identifier.Code);
            foreach (string componentRef in refs.Where(answer.ComponentProfiles.ContainsKey))
            {
                HRIComponentProfile profile = answer.ComponentProfiles[componentRef];
                body.Add(componentRef, UrnOf(profile), profile.Function);
            }
            return body;
        }

        private static IEnumerable<HRIEngineProfile> Sorted(IEnumerable<HRIEngineProfile> engines)
        {
            return engines.OrderBy(engine => engine.Identifier.Code, StringComparer.Ordinal);
        }

        private static IEnumerable<string> Reachable(HRIEngineProfile engine)
        {
            return engine.ComponentIds.Concat(engine.SubProfiles.SelectMany(Reachable));
        }

        private static IEnumerable<string> OwnRefs(HRIEngineProfile engine)
        {
            var below = new HashSet<string>(engine.SubProfiles.SelectMany(Reachable));
            return engine.ComponentIds.Where(componentRef => !below.Contains(componentRef));
        }
    }
}
