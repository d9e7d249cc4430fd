// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// Resumes the session of a lost connection on the next one. Where the gateway does not let it, because it was
    /// restarted or the grace time is over, its journal may know how commands have ended: it is asked for each that is
    /// waited for. All of it runs in the client's strand.
    /// </summary>
    internal sealed class Resumption
    {
        internal const string Extension = "openrois.lease";

        /// <summary>Milliseconds until commands of unknown end are given up: a gateway that has crashed is back by then.</summary>
        private const long Patience = 30000;
        private const int MostResumed = 1024;
        private const int AtOnce = 64;

        /// <summary>Queries for the end of a command that may still run at another gateway: each waits for some seconds.</summary>
        private const int Queries = 6;

        private readonly UnfinishedCommands _commands;
        private readonly Bindings _bindings;
        private readonly ITiming _timing;
        private readonly Strand _strand;
        private bool _extended;
        private string _token = "";
        private string _former = "";
        private long _grace;
        private IReadOnlyList<string> _orphans = new string[0];
        private string _reason = "";
        private IDisposable _givingUp;

        internal Resumption(UnfinishedCommands commands, Bindings bindings, ITiming timing, Strand strand)
        {
            _commands = commands;
            _bindings = bindings;
            _timing = timing;
            _strand = strand;
        }

        /// <summary>Resumes the lost session, or at least gets a token for the next time.</summary>
        /// <param name="session">the new connection</param>
        /// <param name="within">milliseconds that an answer may take</param>
        /// <param name="extended">whether the gateway knows of leases; one that does not gets no such requests</param>
        /// <param name="token">ends it</param>
        internal async Task GreetAsync(JsonRpcSession session, long within, bool extended, CancellationToken token)
        {
            _extended = extended;
            // An attempt that failed half way had a session, too.
            _former = _token != "" ? _token : _former;
            _token = "";
            _orphans = _commands.Ids;
            if (!extended)
            {
                GiveUp();
                return;
            }
            if (_former != "")
            {
                await ResumeAsync(session, within, token);
            }
            if (_token == "")
            {
                await GetTokenAsync(session, within, token);
            }
        }

        /// <summary>Asks how commands have ended that the gateway does not report by itself.</summary>
        internal async Task FindEndsAsync(JsonRpcSession session, long within, CancellationToken token)
        {
            IReadOnlyList<string> orphans = _orphans;
            for (int first = 0; first < orphans.Count; first += AtOnce)
            {
                await Task.WhenAll(orphans.Skip(first).Take(AtOnce).Select(
                    each => FindEndAsync(session, within, each, token)));
            }
            if (ReferenceEquals(_orphans, orphans))
            {
                GiveUp();
            }
        }

        /// <summary>Notes that the connection has ended; arguments as of <see cref="IConnectionOwner"/>.</summary>
        internal void ConnectionEnded(string reason, bool lost, bool again)
        {
            _reason = reason;
            // While another session has taken over this one's commands, or it was closed, there is nothing to resume.
            _former = lost ? _token : "";
            _token = "";
            StopTimer();
            if (again && _extended)
            {
                _orphans = _commands.Ids;
                _givingUp = _timing.After(Math.Max(_grace, Patience), () => _strand.Post(GiveUp));
            }
            else
            {
                _orphans = new string[0];
                _commands.Lose(reason, _commands.Ids);
            }
        }

        private async Task ResumeAsync(JsonRpcSession session, long within, CancellationToken token)
        {
            var given = new ResumeParams { Token = _former, CommandIds = _orphans.Take(MostResumed).ToList() };
            ResumeResult resumed;
            try
            {
                resumed = await RpcCall.AskAsync(session, Methods.LeaseResume, given, within, token);
            }
            catch (Exception error) when (error is RoISException || error is RpcException)
            {
                // The gateway was restarted, or has waited long enough.
                _former = "";
                return;
            }
            _token = resumed.Token;
            _grace = resumed.GraceMs;
            _former = "";
            _orphans = resumed.Forgotten.Concat(_orphans.Skip(MostResumed)).ToList();
            foreach (Lease lease in resumed.Leases.Where(lease => !_bindings.Wants(lease.ComponentRef)))
            {
                // It was given back while there was no connection.
                var released = new ComponentParams { ComponentRef = lease.ComponentRef };
                session.Post(Methods.CommandRelease.Name, RoISJson.ToObject(released));
            }
        }

        private async Task GetTokenAsync(JsonRpcSession session, long within, CancellationToken token)
        {
            try
            {
                LeaseTokenResult told =
                    await RpcCall.AskAsync(session, Methods.LeaseToken, new NoParams(), within, token);
                _token = told.Token;
                _grace = told.GraceMs;
            }
            catch (Exception error) when (error is RoISException || error is RpcException)
            {
                // An application that may not bind needs none, and some gateways have none.
            }
        }

        /// <summary>Asks until two answers: a notification of the end comes right behind the first, before the second.</summary>
        private async Task FindEndAsync(
            JsonRpcSession session, long within, string commandId, CancellationToken token)
        {
            var given = new CommandResultParams { CommandId = commandId };
            string why = "it may still run at another gateway";
            int answers = 0;
            for (int query = 0; query < Queries; query++)
            {
                if (!_commands.Contains(commandId))
                {
                    return;
                }
                if (answers == 2)
                {
                    why = "its end was notified over the lost connection, and never arrived";
                    break;
                }
                try
                {
                    await RpcCall.AskAsync(session, Methods.CommandGetCommandResult, given, within, token);
                    answers++;
                }
                catch (ComponentFailedException)
                {
                    // It failed, or did not end before the gateway did: a notification says so, too.
                    answers++;
                }
                catch (TimedOutException)
                {
                    // The gateway that runs it may be lost. This one has waited for some seconds, and will know.
                }
                catch (Exception error) when (error is RoISException || error is RpcException)
                {
                    why = "the gateway does not know of it";
                    break;
                }
            }
            _commands.Lose(_reason + "; " + why, new[] { commandId });
        }

        /// <summary>Gives up the commands of the lost session: their ends are not notified any more.</summary>
        private void GiveUp()
        {
            StopTimer();
            IReadOnlyList<string> orphans = _orphans;
            _orphans = new string[0];
            _former = "";
            _commands.Lose(_reason, orphans);
        }

        private void StopTimer()
        {
            _givingUp?.Dispose();
            _givingUp = null;
        }
    }
}
