// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// System, Command, Query and Event interface of one gateway (RoIS 2.0, 8.2), by the standard's names.
    ///
    /// Every operation throws a <see cref="RoISException"/> for a return code other than OK, <see cref="RpcException"/>
    /// where the gateway does not know the method or its params, <see cref="ConnectionLostException"/>, and
    /// <see cref="TimeoutException"/>; a token ends it with <see cref="OperationCanceledException"/>, and what it did
    /// nevertheless is undone. Without a connection operations wait for one, up to the request timeout; those that set
    /// parameters or execute do not: what moves a robot is not kept for later. All may be called from any thread.
    /// </summary>
    public abstract class Operations : ClientNotices
    {
        internal Operations(SynchronizationContext context, ClientOptions options)
            : base(context, options.HandlerFailed)
        {
        }

        /// <summary>The gateway's extensions beyond RoIS; none where it does not know <c>openrois.hello</c>.</summary>
        public IReadOnlyCollection<string> Extensions
        {
            get { return Application.Extensions; }
        }

        internal Application Application { get; set; }

        private Connection Connection
        {
            get { return Application.Connection; }
        }

        /// <summary>Returns the tree of engines, and the profile of each component that meets a condition.</summary>
        public Task<ProfileResult> GetProfileAsync(
            string condition = "", CancellationToken token = default(CancellationToken))
        {
            return Ask(Methods.SystemGetProfile, new ConditionParams { Condition = condition }, token);
        }

        /// <summary>Returns what is known of a fault.</summary>
        /// <exception cref="BadParameterException">the gateway does not know it, or not any more</exception>
        public async Task<IReadOnlyList<Result>> GetErrorDetailAsync(
            string errorId, CancellationToken token = default(CancellationToken))
        {
            return (await Ask(Methods.SystemGetErrorDetail, new ErrorDetailParams { ErrorId = errorId }, token)).Results;
        }

        /// <summary>Returns the references of the components that meet a <see cref="Condition"/>; of all without one.</summary>
        /// <exception cref="BadParameterException">it is no condition</exception>
        public async Task<IReadOnlyList<string>> SearchAsync(
            string condition = "", CancellationToken token = default(CancellationToken))
        {
            var given = new ConditionParams { Condition = condition };
            return (await Ask(Methods.CommandSearch, given, token)).ComponentRefList;
        }

        /// <summary>Reserves a component. It is bound again after a reconnect, until it is released.</summary>
        /// <exception cref="OutOfResourcesException">another application has it</exception>
        /// <exception cref="UnsupportedException">there is no such component</exception>
        public Task BindAsync(string componentRef, CancellationToken token = default(CancellationToken))
        {
            return Application.Strand.Run(() => Reserve(componentRef, token));
        }

        /// <summary>Reserves one of the components that meet a condition, and returns its reference.</summary>
        /// <exception cref="OutOfResourcesException">other applications have all of them</exception>
        /// <exception cref="UnsupportedException">there is none</exception>
        public Task<string> BindAnyAsync(
            string condition = "", CancellationToken token = default(CancellationToken))
        {
            return Application.Strand.Run(async () =>
            {
                ReferenceResult result = await Connection.AskAsync(
                    Methods.CommandBindAny,
                    new ConditionParams { Condition = condition },
                    token,
                    accepted => Application.Bindings.Use(accepted.ComponentRef),
                    late => ReleaseUnwanted(late.ComponentRef));
                return result.ComponentRef;
            });
        }

        /// <summary>Releases a component; one that is not bound stays so. Without a connection it is released already.</summary>
        public Task ReleaseAsync(string componentRef, CancellationToken token = default(CancellationToken))
        {
            return Application.Strand.Run(async () =>
            {
                Application.Bindings.GaveBack(componentRef);
                try
                {
                    var given = new ComponentParams { ComponentRef = componentRef };
                    await Connection.ActAsync(Methods.CommandRelease, given, token);
                }
                catch (ConnectionLostException)
                {
                    // With its connection the binding ends, or is not resumed.
                }
            });
        }

        /// <summary>Returns the parameters of a component that have a value.</summary>
        public async Task<IReadOnlyList<Parameter>> GetParameterAsync(
            string componentRef, CancellationToken token = default(CancellationToken))
        {
            var given = new ComponentParams { ComponentRef = componentRef };
            return (await Ask(Methods.CommandGetParameter, given, token)).Parameters;
        }

        /// <summary>Changes parameters, all at once; the command that comes back ends when that is done.</summary>
        /// <exception cref="BadParameterException">there is no such parameter, or a value does not fit</exception>
        /// <exception cref="OutOfResourcesException">the component acts, and is not bound by this application</exception>
        public Task<Command> SetParameterAsync(
            string componentRef, IEnumerable<Parameter> parameters, CancellationToken token = default(CancellationToken))
        {
            return Application.Strand.Run(async () =>
            {
                Command command = null;
                var given = new SetParameterParams { ComponentRef = componentRef, Parameters = parameters.ToList() };
                await Connection.ActAsync(
                    Methods.CommandSetParameter,
                    given,
                    token,
                    accepted =>
                    {
                        // Its end may be the very next message.
                        command = new Command(componentRef, "set_parameter", accepted.CommandId);
                        Application.Commands.Expect(new[] { command });
                    });
                return command;
            });
        }

        /// <summary>
        /// Sends a sequence of commands, and returns once the gateway has accepted all of them; a refusal starts nothing.
        /// </summary>
        /// <param name="parts">steps, such as <c>navigation.StartStep()</c>, that run one after another, and
        /// <see cref="Concurrent"/> ones</param>
        public Task<Execution> ExecuteAsync(params SequencePart[] parts)
        {
            return ExecuteAsync(parts, CancellationToken.None);
        }

        /// <summary>The same, with a token that ends the wait for the acceptance.</summary>
        public Task<Execution> ExecuteAsync(IEnumerable<SequencePart> parts, CancellationToken token)
        {
            var commands = new List<Command>();
            var given = new ExecuteParams { CommandUnitList = parts.Select(part => part.Write(commands)).ToList() };
            return Application.Strand.Run(async () =>
            {
                Application.Commands.Expect(commands);
                try
                {
                    await Connection.ActAsync(Methods.CommandExecute, given, token);
                }
                catch (Exception)
                {
                    // Where the wait was given up it may have been accepted; its end is of no interest then.
                    Application.Commands.Drop(commands);
                    throw;
                }
                return new Execution(commands);
            });
        }

        /// <summary>Runs a sequence of commands to its end; arguments as of <see cref="ExecuteAsync(SequencePart[])"/>.</summary>
        /// <exception cref="RoISException">it was refused, and nothing ran; or one failed, and those after it did not run</exception>
        public Task RunAsync(params SequencePart[] parts)
        {
            return RunAsync(parts, CancellationToken.None);
        }

        /// <summary>The same, with a token that ends the wait; commands that were accepted go on.</summary>
        public Task RunAsync(IEnumerable<SequencePart> parts, CancellationToken token)
        {
            return Application.Strand.Run(async () => await (await ExecuteAsync(parts, token)).WaitAsync(token));
        }

        /// <summary>Returns the results of a command of this application that has ended.</summary>
        /// <exception cref="BadParameterException">the gateway does not know it, or not any more</exception>
        public async Task<IReadOnlyList<Result>> GetCommandResultAsync(
            string commandId, CancellationToken token = default(CancellationToken))
        {
            var given = new CommandResultParams { CommandId = commandId };
            return (await Ask(Methods.CommandGetCommandResult, given, token)).Results;
        }

        /// <summary>Queries the one component that answers this and meets a condition.</summary>
        /// <exception cref="UnsupportedException">there is none</exception>
        /// <exception cref="BadParameterException">there are several, or it is no condition</exception>
        public async Task<IReadOnlyList<Result>> QueryAsync(
            string queryType, string condition = "", CancellationToken token = default(CancellationToken))
        {
            var given = new QueryParams { QueryType = queryType, Condition = condition };
            return (await Ask(Methods.QueryQuery, given, token)).Results;
        }

        /// <summary>Returns the results of an event, for as long as the gateway keeps them.</summary>
        public async Task<IReadOnlyList<Result>> GetEventDetailAsync(
            string eventId, CancellationToken token = default(CancellationToken))
        {
            return (await Ask(Methods.EventGetEventDetail, new DetailParams { EventId = eventId }, token)).Results;
        }

        /// <summary>
        /// Calls any method of the wire or of an extension, on this connection or not at all:
        /// <c>client.CallAsync(new Method&lt;JObject, AnyResult&gt;("vendor.method"), given)</c>.
        /// </summary>
        public Task<TResult> CallAsync<TParams, TResult>(
            Method<TParams, TResult> method, TParams given, CancellationToken token = default(CancellationToken))
            where TResult : class, IOutcome
        {
            return Application.Strand.Run(() => Connection.ActAsync(method, given, token));
        }

        /// <summary>Binds in the strand; see <see cref="BindAsync"/>.</summary>
        internal async Task Reserve(string componentRef, CancellationToken token)
        {
            using (await Application.Bindings.TurnAsync(componentRef, token))
            {
                await Connection.AskAsync(
                    Methods.CommandBind,
                    new ComponentParams { ComponentRef = componentRef },
                    token,
                    accepted => Application.Bindings.Use(componentRef),
                    late => ReleaseUnwanted(componentRef));
            }
        }

        internal Task<TResult> Ask<TParams, TResult>(
            Method<TParams, TResult> method, TParams given, CancellationToken token)
            where TResult : class, IOutcome
        {
            return Application.Strand.Run(() => Connection.AskAsync(method, given, token));
        }

        /// <summary>Releases a component whose binding came too late, unless it is wanted otherwise.</summary>
        private void ReleaseUnwanted(string componentRef)
        {
            Bindings bindings = Application.Bindings;
            // A task that binds it now would lose it to a release that is sent after its bind.
            if (!bindings.Wants(componentRef) && !bindings.IsInTurn(componentRef))
            {
                Connection.Post(Methods.CommandRelease, new ComponentParams { ComponentRef = componentRef });
            }
        }
    }
}
