// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>A type of components: its URN, and the class with which an application sees one.</summary>
    public abstract class ComponentType
    {
        internal ComponentType(string urn)
        {
            Urn = urn;
        }

        /// <summary>Such as <c>urn:x-rois:def:component:OMG::Navigation</c>.</summary>
        public string Urn { get; private set; }

        /// <summary>Without the authority, such as <c>Navigation</c>.</summary>
        public string Code
        {
            get { return CodeOf(Urn); }
        }

        public override string ToString()
        {
            return Code;
        }

        internal static string CodeOf(string urn)
        {
            return urn.Substring(urn.LastIndexOf(':') + 1);
        }

        internal abstract ComponentProxy Make(Client client, string componentRef);
    }

    /// <summary>A type of components that are seen as <typeparamref name="T"/>.</summary>
    public sealed class ComponentType<T> : ComponentType
        where T : ComponentProxy
    {
        private readonly Func<Client, string, T> _make;

        public ComponentType(string urn, Func<Client, string, T> make)
            : base(urn)
        {
            _make = make;
        }

        internal override ComponentProxy Make(Client client, string componentRef)
        {
            return MakeProxy(client, componentRef);
        }

        internal T MakeProxy(Client client, string componentRef)
        {
            return _make(client, componentRef);
        }
    }

    /// <summary>
    /// One component of an engine, with its commands, queries and events as members. The basic components have classes in
    /// <c>OpenRoIS.Components</c>; one's own is written in the same way:
    /// <code>
    /// public sealed class Lamp : RoISCommon
    /// {
    ///     public static new readonly ComponentType&lt;Lamp&gt; Type = new ComponentType&lt;Lamp&gt;(
    ///         "urn:x-rois:def:component:Example::Lamp", (client, componentRef) => new Lamp(client, componentRef));
    ///
    ///     public Lamp(Client client, string componentRef) : base(client, componentRef) { }
    ///
    ///     public ComponentEvent&lt;bool&gt; Switched
    ///     {
    ///         get { return Event("switched", told => told.Value&lt;bool&gt;("on", "bool")); }
    ///     }
    ///
    ///     public Task SwitchAsync(bool on)
    ///     {
    ///         return Command("switch", new Arguments().Add("on", "bool", on)).RunAsync();
    ///     }
    /// }
    /// </code>
    /// All operations throw what those of <see cref="Operations"/> throw.
    /// </summary>
    public class ComponentProxy
    {
        public ComponentProxy(Client client, string componentRef)
        {
            if (client == null || componentRef == null)
            {
                throw new ArgumentNullException(client == null ? "client" : "componentRef");
            }
            Client = client;
            ComponentRef = componentRef;
        }

        /// <summary>Where the component is: the id of its engine, a slash and its name.</summary>
        public string ComponentRef { get; private set; }

        public Client Client { get; private set; }

        /// <summary>Reserves the component; an actuation takes commands from its holder alone.</summary>
        /// <exception cref="OutOfResourcesException">another application has it</exception>
        public Task BindAsync(CancellationToken token = default(CancellationToken))
        {
            return Client.BindAsync(ComponentRef, token);
        }

        /// <summary>Gives the component back.</summary>
        public Task ReleaseAsync(CancellationToken token = default(CancellationToken))
        {
            return Client.ReleaseAsync(ComponentRef, token);
        }

        /// <summary>Returns the component's profile.</summary>
        /// <exception cref="UnsupportedException">there is no such component</exception>
        public async Task<HRIComponentProfile> GetProfileAsync(CancellationToken token = default(CancellationToken))
        {
            ProfileResult answer = await Client.GetProfileAsync(Condition.ComponentRef(ComponentRef), token);
            HRIComponentProfile profile;
            if (!answer.ComponentProfiles.TryGetValue(ComponentRef, out profile))
            {
                throw new UnsupportedException("there is no component " + ComponentRef);
            }
            return profile;
        }

        public override string ToString()
        {
            return GetType().Name + " " + ComponentRef;
        }

        /// <summary>Returns a command that gives nothing.</summary>
        protected Step Command(string commandType, Arguments arguments = null)
        {
            return new Step(Client, ComponentRef, commandType, arguments);
        }

        /// <summary>Returns a command, with what reads what it gives.</summary>
        protected Step<T> Command<T>(string commandType, Arguments arguments, Func<Payload, T> read)
        {
            return new Step<T>(Client, ComponentRef, commandType, arguments, read);
        }

        /// <summary>Queries the component.</summary>
        protected Task<T> QueryAsync<T>(string queryType, Func<Payload, T> read, CancellationToken token)
        {
            return Client.Application.Strand.Run(async () =>
            {
                var values = await Client.QueryAsync(queryType, Condition.ComponentRef(ComponentRef), token);
                return Payload.Read(queryType + " of " + ComponentRef, values, read);
            });
        }

        /// <summary>Returns the parameters.</summary>
        protected Task<T> ParametersAsync<T>(Func<Payload, T> read, CancellationToken token)
        {
            return Client.Application.Strand.Run(async () =>
            {
                IReadOnlyList<Parameter> values = await Client.GetParameterAsync(ComponentRef, token);
                return Payload.Read("get_parameter of " + ComponentRef, values.Select(AsResult), read);
            });
        }

        /// <summary>Returns an event of the component.</summary>
        protected ComponentEvent<T> Event<T>(string eventType, Func<Payload, T> read)
        {
            return new ComponentEvent<T>(Client, eventType, ComponentRef, read);
        }

        private static Result AsResult(Parameter parameter)
        {
            return new Result
            {
                Name = parameter.Name,
                DataTypeRef = parameter.DataTypeRef,
                Value = parameter.Value
            };
        }
    }
}
