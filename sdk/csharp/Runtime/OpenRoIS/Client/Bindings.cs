// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// Components that are bound, and are to be bound again on the next connection. All of it runs in the client's strand.
    /// </summary>
    internal sealed class Bindings
    {
        private readonly Dictionary<string, Binding> _wanted = new Dictionary<string, Binding>();
        private readonly Dictionary<string, Turns> _turns = new Dictionary<string, Turns>();
        private readonly Action<BindingLoss> _lost;
        private readonly Action<string> _restored;
        private readonly Action<BindingLoan> _lent;

        internal Bindings(Action<BindingLoss> lost, Action<string> restored, Action<BindingLoan> lent)
        {
            _lost = lost;
            _restored = restored;
            _lent = lent;
        }

        /// <summary>Whether a component that is wanted is not bound, and does not come back by itself.</summary>
        internal bool Incomplete
        {
            get { return _wanted.Values.Any(binding => !binding.Held && !binding.Lent); }
        }

        /// <summary>
        /// Waits for the turn of a component; disposing of what comes back ends it. A release must not overtake the bind of
        /// another task.
        /// </summary>
        internal async Task<IDisposable> TurnAsync(string componentRef, CancellationToken token)
        {
            Turns turns;
            if (!_turns.TryGetValue(componentRef, out turns))
            {
                _turns[componentRef] = turns = new Turns(() => _turns.Remove(componentRef));
            }
            await turns.EnterAsync(token);
            return turns;
        }

        /// <summary>Whether a task binds it at this moment.</summary>
        internal bool IsInTurn(string componentRef)
        {
            return _turns.ContainsKey(componentRef);
        }

        internal bool Wants(string componentRef)
        {
            return _wanted.ContainsKey(componentRef);
        }

        /// <summary>Notes that it was bound once more.</summary>
        internal void Use(string componentRef)
        {
            Binding binding;
            if (!_wanted.TryGetValue(componentRef, out binding))
            {
                _wanted[componentRef] = binding = new Binding();
            }
            binding.Held = true;
            binding.Missed = false;
            binding.Lent = false;
            binding.Uses++;
        }

        /// <summary>Notes that one user needs it no more; returns whether that was the last.</summary>
        internal bool Unuse(string componentRef)
        {
            Binding binding;
            return _wanted.TryGetValue(componentRef, out binding) && --binding.Uses <= 0;
        }

        /// <summary>Notes that it is not wanted any more.</summary>
        internal void GaveBack(string componentRef)
        {
            _wanted.Remove(componentRef);
        }

        /// <summary>Notes which application holds a component now.</summary>
        /// <returns>whether it does not come back by itself any more, and has to be bound again</returns>
        internal bool HolderChanged(LeaseChangedNotification told)
        {
            switch (told.State)
            {
                case LeaseState.Mine:
                    Returned(told.ComponentRef);
                    return false;
                case LeaseState.Free:
                    return NotReturned(told.ComponentRef);
                case LeaseState.Held:
                    if (told.ReturnPosition > 0)
                    {
                        Lend(told);
                    }
                    else
                    {
                        Taken(told.ComponentRef, told.Reason);
                    }
                    return false;
                default:
                    return false;
            }
        }

        /// <summary>Notes that another application has it for a time, after which it comes back.</summary>
        private void Lend(LeaseChangedNotification told)
        {
            Binding binding;
            if (_wanted.TryGetValue(told.ComponentRef, out binding) && binding.Held)
            {
                binding.Held = false;
                binding.Missed = true;
                binding.Lent = true;
                TimeSpan returnsIn = TimeSpan.FromMilliseconds(told.ReturnMs);
                _lent(new BindingLoan(told.ComponentRef, told.Holder, returnsIn));
            }
        }

        /// <summary>Notes that it has come back.</summary>
        private void Returned(string componentRef)
        {
            Binding binding;
            if (_wanted.TryGetValue(componentRef, out binding) && binding.Lent)
            {
                binding.Held = true;
                binding.Missed = false;
                binding.Lent = false;
                _restored(componentRef);
            }
        }

        /// <summary>Notes that it is free: what was lent is bound again as what was lost is.</summary>
        private bool NotReturned(string componentRef)
        {
            Binding binding;
            if (!_wanted.TryGetValue(componentRef, out binding) || !binding.Lent)
            {
                return false;
            }
            binding.Lent = false;
            return true;
        }

        /// <summary>Notes that another application has it now: it is not bound again.</summary>
        private void Taken(string componentRef, string reason)
        {
            Binding binding;
            if (_wanted.TryGetValue(componentRef, out binding) && (binding.Held || binding.Lent))
            {
                _wanted.Remove(componentRef);
                string said = "another application holds " + componentRef + " now: " + reason;
                _lost(new BindingLoss(componentRef, new OutOfResourcesException(said, reason)));
            }
        }

        /// <summary>Notes that the connection has ended, and with it every binding.</summary>
        internal void ConnectionEnded()
        {
            foreach (Binding binding in _wanted.Values)
            {
                binding.Held = false;
                binding.Lent = false;
            }
        }

        /// <summary>Binds everything again; to bind what is bound already changes nothing.</summary>
        /// <exception cref="ConnectionLostException">the connection ended</exception>
        internal Task RenewAsync(JsonRpcSession session, long within, CancellationToken token)
        {
            // What another application has for a time comes back by itself.
            return Task.WhenAll(_wanted.Where(each => !each.Value.Lent).ToList().Select(
                each => RenewAsync(session, within, each.Key, each.Value, token)));
        }

        private async Task RenewAsync(
            JsonRpcSession session, long within, string componentRef, Binding binding, CancellationToken token)
        {
            var given = new ComponentParams { ComponentRef = componentRef };
            try
            {
                await RpcCall.AskAsync(session, Methods.CommandBind, given, within, token);
            }
            catch (Exception error) when (error is RoISException || error is RpcException || error is TimeoutException)
            {
                binding.Held = false;
                if (!binding.Missed)
                {
                    binding.Missed = true;
                    _lost(new BindingLoss(componentRef, error));
                }
                return;
            }
            Binding now;
            if (!_wanted.TryGetValue(componentRef, out now) || now != binding)
            {
                // It was given back meanwhile, and the gateway may have done that first.
                session.Post(Methods.CommandRelease.Name, RoISJson.ToObject(given));
            }
            else if (!binding.Held)
            {
                binding.Held = true;
                binding.Missed = false;
                _restored(componentRef);
            }
        }

        private sealed class Binding
        {
            /// <summary>Whether the gateway has it bound, as far as is known.</summary>
            internal bool Held;

            /// <summary>Whether the application was told that it is not.</summary>
            internal bool Missed;

            /// <summary>Whether another application has it for a time.</summary>
            internal bool Lent;

            /// <summary>How many bodies and calls of bind want it.</summary>
            internal int Uses;
        }

        /// <summary>One turn after another.</summary>
        private sealed class Turns : IDisposable
        {
            private readonly LinkedList<TaskCompletionSource<bool>> _waiting =
                new LinkedList<TaskCompletionSource<bool>>();
            private readonly Action _empty;
            private bool _taken;

            internal Turns(Action empty)
            {
                _empty = empty;
            }

            internal async Task EnterAsync(CancellationToken token)
            {
                if (!_taken)
                {
                    _taken = true;
                    return;
                }
                LinkedListNode<TaskCompletionSource<bool>> place = _waiting.AddLast(
                    new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously));
                try
                {
                    await place.Value.Task.OrCanceled(token);
                }
                catch (OperationCanceledException)
                {
                    if (place.List != null)
                    {
                        _waiting.Remove(place);
                    }
                    else
                    {
                        Dispose();
                    }
                    throw;
                }
            }

            public void Dispose()
            {
                if (_waiting.Count == 0)
                {
                    _empty();
                    return;
                }
                TaskCompletionSource<bool> next = _waiting.First.Value;
                _waiting.RemoveFirst();
                next.TrySetResult(true);
            }
        }
    }
}
