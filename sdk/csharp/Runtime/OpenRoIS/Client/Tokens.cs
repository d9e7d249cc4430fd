// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>Tokens as an application has them, and their renewal on an open connection.</summary>
    internal static class Tokens
    {
        /// <summary>Milliseconds until the newest token is shown again, where it was not a new one yet.</summary>
        private const long Pause = 10000;
        private const int Attempts = 6;

        /// <summary>A token that lasts no longer (seconds) than the one that ends is none.</summary>
        private const long Enough = 60;

        /// <summary>The newest token, without the line end that it had in a file.</summary>
        /// <exception cref="ConnectionFailedException">there is none</exception>
        internal static string Read(Func<string> newest)
        {
            string token;
            try
            {
                token = (newest() ?? "").Trim();
            }
            catch (Exception error)
            {
                throw new ConnectionFailedException("ClientOptions.Token has failed: " + error.Message);
            }
            // Any other text must not get into a header, whose errors would repeat it.
            if (token == "" || token.Any(character => character <= ' ' || character > '~'))
            {
                throw new ConnectionFailedException(
                    "ClientOptions.Token returns no token: it is one line, as `openrois token issue` prints it");
            }
            return token;
        }

        /// <summary>Shows the newest token to a gateway that says that the present one ends soon.</summary>
        internal static async Task RenewAsync(
            JsonRpcSession session, ClientOptions options, long within, CancellationToken token)
        {
            for (int attempt = 0; attempt < Attempts; attempt++)
            {
                if (attempt > 0)
                {
                    await options.Timing.DelayAsync(Pause, token);
                }
                try
                {
                    var shown = new AuthRefreshParams { Token = Read(options.Token) };
                    AuthRefreshResult result = await RpcCall.AskAsync(session, Methods.AuthRefresh, shown, within, token);
                    if (result.Seconds > Enough)
                    {
                        return;
                    }
                }
                catch (Exception error) when (!(error is OperationCanceledException || error is ConnectionLostException))
                {
                    // Perhaps there is a newer one in a while; without one the gateway closes the connection, and says why.
                }
            }
        }
    }
}
