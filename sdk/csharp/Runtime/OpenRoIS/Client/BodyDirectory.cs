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

    /// <summary>A body as the profile describes it.</summary>
    internal sealed class BodyProfile
    {
        internal readonly string EngineId;

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

        internal bool Has(string urn)
        {
            return Types.ContainsValue(urn);
        }
    }

    /// <summary>
    /// Bodies in a gateway's profile. RoIS 2.0 knows engines and components; a body is an engine that owns components: it
    /// lists some that no engine below it lists. What is reachable through it belongs to it, too. Behind the main engine
    /// stand all bodies, so that of those it has only what it owns itself: a body is never put together from two robots.
    /// </summary>
    internal static class BodyDirectory
    {
        /// <summary>The bodies in the order of the profile, inner engines before those around them.</summary>
        internal static List<BodyProfile> Read(ProfileResult answer)
        {
            var bodies = new List<BodyProfile>();
            if (answer.Profile == null)
            {
                return bodies;
            }
            foreach (HRIEngineProfile engine in answer.Profile.SubProfiles)
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
            foreach (HRIEngineProfile inner in engine.SubProfiles)
            {
                Collect(inner, answer, bodies);
            }
            if (OwnRefs(engine).Any(answer.ComponentProfiles.ContainsKey))
            {
                bodies.Add(BodyOf(engine, Reachable(engine), answer));
            }
        }

        private static BodyProfile BodyOf(HRIEngineProfile engine, IEnumerable<string> refs, ProfileResult answer)
        {
            var body = new BodyProfile(engine.Identifier.Code);
            foreach (string componentRef in refs.Where(answer.ComponentProfiles.ContainsKey))
            {
                body.Types[componentRef] = UrnOf(answer.ComponentProfiles[componentRef]);
            }
            return body;
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
