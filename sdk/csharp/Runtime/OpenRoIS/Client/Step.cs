// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>A part of a sequence: a <see cref="Step"/>, or several that are <see cref="Concurrent"/>.</summary>
    public abstract class SequencePart
    {
        internal SequencePart()
        {
        }

        /// <summary>Writes it for the wire, with command ids of its own, and adds a handle for each command.</summary>
        internal abstract ISequenceItem Write(ICollection<Command> commands);

        internal static long? Milliseconds(TimeSpan? delay)
        {
            return delay == null ? (long?)null : (long)Math.Round(delay.Value.TotalMilliseconds);
        }
    }

    /// <summary>
    /// One command that is not sent yet: nothing happens before it is run, alone by <see cref="RunAsync"/> or in a sequence by
    /// <see cref="Operations.RunAsync(SequencePart[])"/>. It can be run any number of times.
    /// </summary>
    public class Step : SequencePart
    {
        private readonly Operations _client;
        private readonly string _componentRef;
        private readonly string _commandType;
        private readonly Arguments _arguments;

        /// <summary>A command of any component.</summary>
        /// <param name="client">runs it</param>
        /// <param name="componentRef">the component</param>
        /// <param name="commandType">such as <c>start</c></param>
        /// <param name="arguments">of the command; null for none</param>
        public Step(Operations client, string componentRef, string commandType, Arguments arguments = null)
        {
            _client = client;
            _componentRef = componentRef;
            _commandType = commandType;
            _arguments = arguments ?? new Arguments();
        }

        /// <summary>The time between its turn and its start; null for none.</summary>
        public TimeSpan? Delay { get; set; }

        /// <summary>Sends it, and returns once the gateway has accepted it.</summary>
        /// <exception cref="RoISException">it was refused: unknown, not bound, or with arguments that do not fit</exception>
        /// <exception cref="ConnectionLostException">there is no connection</exception>
        public async Task<Command> ExecuteAsync(CancellationToken token = default(CancellationToken))
        {
            return (await _client.ExecuteAsync(new SequencePart[] { this }, token)).Commands[0];
        }

        /// <summary>Runs it to its end.</summary>
        /// <param name="token">ends the wait; a command that was accepted goes on</param>
        /// <exception cref="RoISException">it was refused, or ended otherwise than OK</exception>
        /// <exception cref="ConnectionLostException">there is no connection, or it ended first, for good</exception>
        public Task RunAsync(CancellationToken token = default(CancellationToken))
        {
            return _client.Application.Strand.Run(async () => await (await ExecuteAsync(token)).WaitAsync(token));
        }

        internal Operations Client
        {
            get { return _client; }
        }

        internal string What
        {
            get { return _commandType + " of " + _componentRef; }
        }

        internal override ISequenceItem Write(ICollection<Command> commands)
        {
            return WriteUnit(commands);
        }

        internal CommandUnit WriteUnit(ICollection<Command> commands)
        {
            // Without a slash it is no engine's.
            string commandId = Guid.NewGuid().ToString("N");
            commands.Add(new Command(_componentRef, _commandType, commandId));
            return new CommandUnit
            {
                ComponentRef = _componentRef,
                CommandType = _commandType,
                CommandId = commandId,
                Arguments = _arguments.List.ToList(),
                DelayTime = (int?)Milliseconds(Delay)
            };
        }
    }

    /// <summary>A step that gives something.</summary>
    public sealed class Step<T> : Step
    {
        private readonly Func<Payload, T> _read;

        /// <summary>A command of any component.</summary>
        /// <param name="client">runs it</param>
        /// <param name="componentRef">the component</param>
        /// <param name="commandType">such as <c>start</c></param>
        /// <param name="arguments">of the command; null for none</param>
        /// <param name="read">reads what it gives</param>
        public Step(
            Operations client, string componentRef, string commandType, Arguments arguments, Func<Payload, T> read)
            : base(client, componentRef, commandType, arguments)
        {
            _read = read;
        }

        /// <summary>Runs it to its end, and returns what it gave; otherwise as that of a <see cref="Step"/>.</summary>
        public new Task<T> RunAsync(CancellationToken token = default(CancellationToken))
        {
            return Client.Application.Strand.Run(async () =>
            {
                Command command = await ExecuteAsync(token);
                await command.WaitAsync(token);
                return Payload.Read(What, await Client.GetCommandResultAsync(command.CommandId, token), _read);
            });
        }
    }

    /// <summary>Steps that run at the same time; the next part of the sequence waits for all of them.</summary>
    public sealed class Concurrent : SequencePart
    {
        private readonly Step[] _steps;

        public Concurrent(params Step[] steps)
        {
            _steps = steps;
        }

        /// <summary>The time between their turn and their start; null for none. Each may have its own delay too.</summary>
        public TimeSpan? Delay { get; set; }

        internal override ISequenceItem Write(ICollection<Command> commands)
        {
            return new ConcurrentCommands
            {
                CommandList = _steps.Select(step => step.WriteUnit(commands)).ToList(),
                DelayTime = (int?)Milliseconds(Delay)
            };
        }
    }
}
