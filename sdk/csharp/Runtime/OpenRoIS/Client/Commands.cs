// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>A command that the gateway has accepted. It ends once, and any number of tasks may wait for that.</summary>
    public sealed class Command
    {
        private readonly TaskCompletionSource<bool> _ended =
            new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);

        internal Command(string componentRef, string commandType, string commandId)
        {
            ComponentRef = componentRef;
            CommandType = commandType;
            CommandId = commandId;
        }

        /// <summary>The component that runs it.</summary>
        public string ComponentRef { get; private set; }

        public string CommandType { get; private set; }

        /// <summary>What <see cref="Operations.GetCommandResultAsync"/> takes.</summary>
        public string CommandId { get; private set; }

        /// <summary>Its status at the end; null while it runs, and where the connection ended first.</summary>
        public CompletedStatus? Status { get; private set; }

        /// <summary>What <see cref="WaitAsync"/> throws, once it has ended; null where it ended OK.</summary>
        public Exception Error { get; private set; }

        /// <summary>Waits for its end.</summary>
        /// <param name="token">ends the wait; the command goes on</param>
        /// <exception cref="RoISException">it ended otherwise than OK</exception>
        /// <exception cref="ConnectionLostException">the connection ended first, for good: its end is not known</exception>
        public async Task WaitAsync(CancellationToken token = default(CancellationToken))
        {
            await EndAsync(token);
            if (Error != null)
            {
                throw Error;
            }
        }

        /// <summary>Waits until it has ended in any way.</summary>
        internal Task EndAsync(CancellationToken token)
        {
            return _ended.Task.OrCanceled(token);
        }

        internal void Settle(CompletedStatus status, string reason)
        {
            Status = status;
            if (status != CompletedStatus.Ok)
            {
                string name = RoISJson.NameOf(status);
                string unexplained = status == CompletedStatus.Error ? "; the log of its adapter says why" : "";
                string why = reason == "" ? unexplained : ": " + reason;
                Error = RoISException.Of(status, CommandType + " of " + ComponentRef + " ended " + name + why, reason);
            }
            _ended.TrySetResult(true);
        }

        internal void Lose(string reason)
        {
            Error = new ConnectionLostException(CommandType + " of " + ComponentRef + ": " + reason);
            _ended.TrySetResult(true);
        }
    }

    /// <summary>A sequence of commands that the gateway has accepted.</summary>
    public sealed class Execution
    {
        internal Execution(IReadOnlyList<Command> commands)
        {
            Commands = commands;
        }

        /// <summary>The commands, in order.</summary>
        public IReadOnlyList<Command> Commands { get; private set; }

        /// <summary>Waits for the end of all commands.</summary>
        /// <param name="token">ends the wait; the commands go on</param>
        /// <exception cref="RoISException">what the first command that failed has thrown; those after it are aborted</exception>
        /// <exception cref="ConnectionLostException">the connection ended first, for good</exception>
        public async Task WaitAsync(CancellationToken token = default(CancellationToken))
        {
            foreach (Command command in Commands)
            {
                await command.EndAsync(token);
            }
            List<Exception> errors = Commands.Select(each => each.Error).Where(error => error != null).ToList();
            if (errors.Count > 0)
            {
                throw errors.FirstOrDefault(error => !(error is AbortedException)) ?? errors[0];
            }
        }
    }

    /// <summary>The commands of one client that are not finished. All of it runs in the client's strand.</summary>
    internal sealed class UnfinishedCommands
    {
        internal const int Most = 4096;

        private readonly Dictionary<string, Command> _running = new Dictionary<string, Command>();
        private string _explained;
        private string _reason;

        internal IReadOnlyList<string> Ids
        {
            get { return _running.Keys.ToList(); }
        }

        internal bool Contains(string commandId)
        {
            return _running.ContainsKey(commandId);
        }

        /// <summary>Notes commands before they are sent, so that none can end unnoticed.</summary>
        /// <exception cref="OutOfResourcesException">too many are unfinished</exception>
        internal void Expect(IReadOnlyCollection<Command> commands)
        {
            if (_running.Count + commands.Count > Most)
            {
                throw new OutOfResourcesException(
                    Most + " commands of this client are unfinished: wait for the end of some first");
            }
            foreach (Command command in commands)
            {
                _running[command.CommandId] = command;
            }
        }

        /// <summary>Drops commands that were not accepted.</summary>
        internal void Drop(IEnumerable<Command> commands)
        {
            foreach (Command command in commands)
            {
                _running.Remove(command.CommandId);
            }
        }

        /// <summary>Notes the reason of an end that comes right behind it.</summary>
        internal void Explain(string commandId, string reason)
        {
            _explained = commandId;
            _reason = reason;
        }

        internal void Completed(Completed told)
        {
            Command command;
            if (_running.TryGetValue(told.CommandId, out command))
            {
                _running.Remove(told.CommandId);
                command.Settle(told.Status, _explained == told.CommandId ? _reason : "");
            }
            _explained = null;
        }

        /// <summary>Fails commands: their end cannot be known any more.</summary>
        internal void Lose(string reason, IEnumerable<string> commandIds)
        {
            foreach (string commandId in commandIds.ToList())
            {
                Command command;
                if (_running.TryGetValue(commandId, out command))
                {
                    _running.Remove(commandId);
                    command.Lose(reason);
                }
            }
        }
    }
}
